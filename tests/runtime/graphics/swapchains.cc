// Swapchains: their life, and the order of acquire, wait and release. Images are handed out in turn.

#include <algorithm>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

constexpr uint32_t kImages = 3;
constexpr XrDuration kHoldPeriod_ns = 1'000'000;

constexpr XrSwapchainUsageFlags kUsages =
    XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
    XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT |
    XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT | XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT;

// Acquire and release take no parameters of their own: a structure is optional.
template <class T>
bool IsOptional(const T* info, XrStructureType type) {
  return info == nullptr || info->type == type;
}

bool IsStatic(const XrSwapchainCreateInfo& info) {
  return (info.createFlags & XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT) != 0;
}

// What no graphics API has a say in. Every view of this system has one sample.
XrResult CheckCreateInfo(const Session& session, const XrSwapchainCreateInfo& info) {
  OMNI_REQUIRE(
      info.sampleCount != 0 && info.width != 0 && info.height != 0 && info.arraySize != 0 && info.mipCount != 0,
      XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info.faceCount == 1 || (info.faceCount == 6 && info.width == info.height), XR_ERROR_VALIDATION_FAILURE);
  const bool known = session.graphics != nullptr && std::count(session.graphics->formats().begin(),
                                                               session.graphics->formats().end(), info.format) != 0;
  OMNI_REQUIRE(known, XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED);
  OMNI_REQUIRE((info.createFlags & ~XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT) == 0 && (info.usageFlags & ~kUsages) == 0,
               XR_ERROR_FEATURE_UNSUPPORTED);
  OMNI_REQUIRE(info.sampleCount == 1, XR_ERROR_FEATURE_UNSUPPORTED);
  return XR_SUCCESS;
}

}  // namespace

XrResult EnumerateSwapchainFormats(XrSession session, uint32_t capacity, uint32_t* count, int64_t* formats) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  const std::vector<int64_t> all = owner->graphics == nullptr ? std::vector<int64_t>() : owner->graphics->formats();
  return TwoCall(static_cast<uint32_t>(all.size()), capacity, count, formats,
                 [&all](uint32_t i, int64_t& out) { out = all[i]; });
}

XrResult CreateSwapchain(XrSession session, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_SWAPCHAIN_CREATE_INFO) && swapchain != nullptr, XR_ERROR_VALIDATION_FAILURE);
  if (const XrResult check = CheckCreateInfo(*owner, *info); XR_FAILED(check)) return check;
  const auto created = std::make_shared<Swapchain>();
  created->session = owner;
  created->info = *info;
  created->info.next = nullptr;
  created->count = IsStatic(*info) ? 1 : kImages;
  const XrResult made = owner->graphics->CreateImages(*info, created->count, &created->images);
  if (XR_FAILED(made)) return made;
  *swapchain = AddChild<XrSwapchain>(state, *owner, created);
  return XR_SUCCESS;
}

XrResult DestroySwapchain(XrSwapchain swapchain) { return DestroyChild<Swapchain>(swapchain); }

XrResult EnumerateSwapchainImages(XrSwapchain swapchain, uint32_t capacity, uint32_t* count,
                                  XrSwapchainImageBaseHeader* images) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Swapchain, owner, swapchain);
  const Images& all = *owner->images;
  // An array of the API's own structures, which are larger than their header.
  const auto at = [&](uint32_t i) { return reinterpret_cast<char*>(images) + i * all.structure_size(); };
  for (uint32_t i = 0; images != nullptr && i < capacity; ++i) {
    OMNI_REQUIRE(reinterpret_cast<const XrSwapchainImageBaseHeader*>(at(i))->type == all.structure(),
                 XR_ERROR_VALIDATION_FAILURE);
  }
  return TwoCall(owner->count, capacity, count, images,
                 [&](uint32_t i, XrSwapchainImageBaseHeader&) { all.Describe(i, at(i)); });
}

XrResult AcquireSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo* info, uint32_t* index) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Swapchain, owner, swapchain);
  OMNI_REQUIRE(IsOptional(info, XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO) && index != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(owner->acquired.size() < owner->count, XR_ERROR_CALL_ORDER_INVALID);
  OMNI_REQUIRE(!IsStatic(owner->info) || owner->released < 0, XR_ERROR_CALL_ORDER_INVALID);
  OMNI_REQUIRE(owner->images->HandOver(owner->next), XR_ERROR_RUNTIME_FAILURE);
  *index = owner->next;
  owner->acquired.push_back(owner->next);
  owner->next = (owner->next + 1) % owner->count;
  return XR_SUCCESS;
}

// The display is done with an image at once, unless a test holds it.
XrResult WaitSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageWaitInfo* info) {
  State& state = TheState();
  OMNI_REQUIRE(Is(info, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO), XR_ERROR_VALIDATION_FAILURE);
  const XrTime begin = Now();
  for (;;) {
    {
      const std::unique_lock lock(state.mutex);
      OMNI_FIND(Swapchain, owner, swapchain);
      OMNI_REQUIRE(!owner->acquired.empty() && !owner->waited, XR_ERROR_CALL_ORDER_INVALID);
      if (!state.world.holds_images) {
        owner->waited = true;
        return XR_SUCCESS;
      }
    }
    if (Now() - begin >= info->timeout) return XR_TIMEOUT_EXPIRED;
    SleepUntil(Now() + kHoldPeriod_ns);
  }
}

XrResult ReleaseSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Swapchain, owner, swapchain);
  OMNI_REQUIRE(IsOptional(info, XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(owner->waited, XR_ERROR_CALL_ORDER_INVALID);
  owner->released = static_cast<int>(owner->acquired.front());
  owner->acquired.pop_front();
  owner->waited = false;
  return XR_SUCCESS;
}

}  // namespace omni::runtime
