// Swapchains: what they are made of, and the order of their calls.

#include <algorithm>
#include <functional>
#include <random>

#include "tests/runtime/cases/graphics/vulkan_fixture.h"

namespace omni::runtime {
namespace {

using Change = std::function<void(XrSwapchainCreateInfo&)>;

class HeadlessSwapchains : public RuntimeTest {};

TEST_F(HeadlessSwapchains, ThereAreNone) {
  Start();
  uint32_t count = 7;
  ASSERT_EQ(xrEnumerateSwapchainFormats(session_, 0, &count, nullptr), XR_SUCCESS);
  EXPECT_EQ(count, 0U);
  auto info = Make<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
  info.format = VK_FORMAT_R8G8B8A8_SRGB;
  info.sampleCount = info.width = info.height = info.faceCount = info.arraySize = info.mipCount = 1;
  XrSwapchain swapchain = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateSwapchain(session_, &info, &swapchain), XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED);
}

class Swapchains : public VulkanTest {};

TEST_F(Swapchains, FormatsAreEnumeratedTheSameEveryTime) {
  uint32_t count = 0;
  ASSERT_EQ(xrEnumerateSwapchainFormats(session_, 0, &count, nullptr), XR_SUCCESS);
  ASSERT_GT(count, 1U);
  std::vector<int64_t> first(count);
  EXPECT_EQ(xrEnumerateSwapchainFormats(session_, count - 1, &count, first.data()), XR_ERROR_SIZE_INSUFFICIENT);
  ASSERT_EQ(xrEnumerateSwapchainFormats(session_, count, &count, first.data()), XR_SUCCESS);
  std::vector<int64_t> second(count);
  ASSERT_EQ(xrEnumerateSwapchainFormats(session_, count, &count, second.data()), XR_SUCCESS);
  EXPECT_EQ(first, second);
  EXPECT_EQ(std::count(first.begin(), first.end(), VK_FORMAT_R8G8B8A8_SRGB), 1);
  EXPECT_EQ(std::count(first.begin(), first.end(), VK_FORMAT_D32_SFLOAT), 1);
  for (const int64_t format : first) {
    XrSwapchainCreateInfo info = ColorInfo();
    info.format = format;
    info.usageFlags = XR_SWAPCHAIN_USAGE_SAMPLED_BIT;
    AddSwapchain(info);
  }
}

TEST_F(Swapchains, CreationRejectsWhatTheSpecificationExcludes) {
  struct Case {
    XrResult result;
    Change change;
  };
  const Case cases[] = {
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.type = XR_TYPE_SESSION_CREATE_INFO; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.width = 0; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.height = 0; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.sampleCount = 0; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.arraySize = 0; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.mipCount = 0; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.faceCount = 2; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.faceCount = 6; }},  // not square
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.width = 1U << 20; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.arraySize = 1U << 20; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& info) { info.mipCount = 100; }},
      {XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, [](auto& info) { info.format = 0; }},
      {XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, [](auto& info) { info.format = -1; }},
      {XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, [](auto& info) { info.format = VK_FORMAT_R8_UINT; }},
      {XR_ERROR_FEATURE_UNSUPPORTED, [](auto& info) { info.createFlags = XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT; }},
      {XR_ERROR_FEATURE_UNSUPPORTED, [](auto& info) { info.createFlags = 1U << 30; }},
      {XR_ERROR_FEATURE_UNSUPPORTED, [](auto& info) { info.usageFlags |= 1U << 30; }},
      {XR_ERROR_FEATURE_UNSUPPORTED,
       [](auto& info) { info.usageFlags = XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT; }},  // of a colour
      {XR_ERROR_FEATURE_UNSUPPORTED, [](auto& info) { info.format = VK_FORMAT_D32_SFLOAT; }},   // as a colour
      {XR_ERROR_FEATURE_UNSUPPORTED, [](auto& info) { info.sampleCount = 2; }},
  };
  for (const Case& one : cases) {
    XrSwapchainCreateInfo info = ColorInfo();
    one.change(info);
    XrSwapchain swapchain = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateSwapchain(session_, &info, &swapchain), one.result) << "case " << &one - cases;
  }
  const XrSwapchainCreateInfo info = ColorInfo();
  EXPECT_EQ(xrCreateSwapchain(session_, &info, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xrCreateSwapchain(session_, nullptr, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Swapchains, ImagesAreEnumeratedIntoStructuresOfTheApi) {
  const XrSwapchain swapchain = AddSwapchain(ColorInfo());
  const auto first = Images(swapchain);
  ASSERT_EQ(first.size(), 3U);
  const auto second = Images(swapchain);
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_NE(first[i].image, VK_NULL_HANDLE);
    EXPECT_EQ(first[i].image, second[i].image);
    for (size_t j = 0; j < i; ++j) EXPECT_NE(first[i].image, first[j].image);
  }
  std::vector<XrSwapchainImageVulkanKHR> images = first;
  auto* const headers = reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data());
  uint32_t count = 0;
  EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 2, &count, headers), XR_ERROR_SIZE_INSUFFICIENT);
  EXPECT_EQ(count, 3U);
  images[2].type = XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR;
  EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 3, &count, headers), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 3, nullptr, headers), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Swapchains, StaticSwapchainHasOneImageThatIsAcquiredOnce) {
  XrSwapchainCreateInfo info = ColorInfo();
  info.createFlags = XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT;
  const XrSwapchain swapchain = AddSwapchain(info);
  EXPECT_EQ(Images(swapchain).size(), 1U);
  ASSERT_EQ(Acquire(swapchain), XR_SUCCESS);
  EXPECT_EQ(Acquire(swapchain), XR_ERROR_CALL_ORDER_INVALID);
  ASSERT_EQ(Wait(swapchain), XR_SUCCESS);
  ASSERT_EQ(Release(swapchain), XR_SUCCESS);
  EXPECT_EQ(Acquire(swapchain), XR_ERROR_CALL_ORDER_INVALID);
}

// Against a model: the images that are acquired, oldest first, and whether the oldest was waited for.
TEST_F(Swapchains, CallsInAnyOrderFollowTheSpecification) {
  const XrSwapchain swapchain = AddSwapchain(ColorInfo());
  std::mt19937 random(1);
  std::vector<uint32_t> acquired;
  bool waited = false;
  int rejected = 0;
  for (int i = 0; i < 2000; ++i) {
    XrResult expected = XR_ERROR_CALL_ORDER_INVALID;
    XrResult result = XR_SUCCESS;
    switch (random() % 3) {
      case 0: {
        uint32_t index = 99;
        result = Acquire(swapchain, &index);
        if (acquired.size() == 3) break;
        expected = XR_SUCCESS;
        ASSERT_LT(index, 3U);
        EXPECT_EQ(std::count(acquired.begin(), acquired.end(), index), 0) << "an image that is in use";
        acquired.push_back(index);
        break;
      }
      case 1:
        result = Wait(swapchain);
        if (acquired.empty() || waited) break;
        expected = XR_SUCCESS;
        waited = true;
        break;
      default:
        result = Release(swapchain);
        if (!waited) break;
        expected = XR_SUCCESS;
        acquired.erase(acquired.begin());
        waited = false;
    }
    ASSERT_EQ(result, expected) << "call " << i;
    if (result != XR_SUCCESS) ++rejected;
  }
  EXPECT_GT(rejected, 100);
}

TEST_F(Swapchains, WaitTimesOutWhileTheDisplayReadsAndThenGetsTheSameImage) {
  const XrSwapchain swapchain = AddSwapchain(ColorInfo());
  ASSERT_EQ(Acquire(swapchain), XR_SUCCESS);
  ASSERT_EQ(omni_test_hold_images(1), 0);
  for (const XrDuration timeout : {XrDuration{0}, XrDuration{-5}, XrDuration{2'000'000}})
    EXPECT_EQ(Wait(swapchain, timeout), XR_TIMEOUT_EXPIRED) << timeout;
  EXPECT_EQ(Release(swapchain), XR_ERROR_CALL_ORDER_INVALID) << "it was not waited for successfully";
  ASSERT_EQ(omni_test_hold_images(0), 0);
  EXPECT_EQ(Wait(swapchain, XR_INFINITE_DURATION), XR_SUCCESS);
  EXPECT_EQ(Release(swapchain), XR_SUCCESS);
}

TEST_F(Swapchains, StructuresOfTheCallsAreChecked) {
  const XrSwapchain swapchain = AddSwapchain(ColorInfo());
  auto acquire = Make<XrSwapchainImageAcquireInfo>(XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO);
  auto wait = Make<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
  auto release = Make<XrSwapchainImageReleaseInfo>(XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO);
  uint32_t index = 0;
  EXPECT_EQ(xrAcquireSwapchainImage(swapchain, &acquire, nullptr), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(xrAcquireSwapchainImage(swapchain, &acquire, &index), XR_SUCCESS);
  EXPECT_EQ(xrWaitSwapchainImage(swapchain, nullptr), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(xrWaitSwapchainImage(swapchain, &wait), XR_SUCCESS);
  release.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO;
  EXPECT_EQ(xrReleaseSwapchainImage(swapchain, &release), XR_ERROR_VALIDATION_FAILURE);
  release.type = XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO;
  EXPECT_EQ(xrReleaseSwapchainImage(swapchain, &release), XR_SUCCESS);
  acquire.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO;
  EXPECT_EQ(xrAcquireSwapchainImage(swapchain, &acquire, &index), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Swapchains, DestroyedOnesAreGoneWithTheirSessionToo) {
  const XrSwapchain one = AddSwapchain(ColorInfo());
  const XrSwapchain two = AddSwapchain(ColorInfo());
  ASSERT_EQ(xrDestroySwapchain(one), XR_SUCCESS);
  EXPECT_EQ(xrDestroySwapchain(one), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Acquire(one), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Wait(one), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Release(one), XR_ERROR_HANDLE_INVALID);
  ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
  EXPECT_EQ(Acquire(two), XR_ERROR_HANDLE_INVALID);
}

TEST_F(Swapchains, LostSessionAllowsOnlyDestruction) {
  const XrSwapchain swapchain = AddSwapchain(ColorInfo());
  ASSERT_EQ(omni_test_lose_session(), 0);
  EXPECT_EQ(Acquire(swapchain), XR_ERROR_SESSION_LOST);
  EXPECT_EQ(xrDestroySwapchain(swapchain), XR_SUCCESS);
}

}  // namespace
}  // namespace omni::runtime
