#include "layer/src/instance.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace omni::layer {
namespace {

Hand OwnedHand(Log& log) {
  const char* hand = std::getenv("OMNI_HAND");
  if (!hand || !*hand || std::strcmp(hand, "right") == 0) return Hand::kRight;
  if (std::strcmp(hand, "left") == 0) return Hand::kLeft;
  log.Line(std::string("OMNI_HAND=") + hand + " is neither left nor right: the pen is in the right hand");
  return Hand::kRight;
}

XrPath ToPath(const Dispatch& next, XrInstance instance, std::string_view text) {
  XrPath path = XR_NULL_PATH;
  return XR_SUCCEEDED(next.StringToPath(instance, std::string(text).c_str(), &path)) ? path : XR_NULL_PATH;
}

}  // namespace

Instance::Instance(InstanceSetup setup)
    : handle(setup.handle),
      next(setup.next),
      hide_timespec(setup.hide_timespec),
      profiles(LoadProfiles()),
      hand(OwnedHand(log)),
      hand_path(ToPath(setup.next, setup.handle, UserPath(hand))),
      clock(setup.handle, setup.next.ConvertTimespecTimeToTimeKHR),
      link(std::move(setup.connection), log),
      enabled_(std::move(setup.enabled)),
      only_ours_(std::move(setup.only_ours)) {
  const std::int64_t now = MonotonicNow_ns();
  clock.Refresh(now);
  link.Poll(now);
}

bool Instance::Enabled(std::string_view extension) const {
  return std::find(enabled_.begin(), enabled_.end(), extension) != enabled_.end();
}

bool Instance::OnlyOurs(std::string_view extension) const {
  return std::find(only_ours_.begin(), only_ours_.end(), extension) != only_ours_.end();
}

std::string Instance::PathText(XrPath path) {
  const std::lock_guard lock(path_mutex_);
  const auto known = path_texts_.find(path);
  if (known != path_texts_.end()) return known->second;
  char text[XR_MAX_PATH_LENGTH] = {};
  std::uint32_t length = 0;
  if (path == XR_NULL_PATH || XR_FAILED(next.PathToString(handle, path, sizeof(text), &length, text))) return {};
  return path_texts_.emplace(path, text).first->second;
}

XrPath Instance::PathOf(const std::string& text) {
  const std::lock_guard lock(path_mutex_);
  const auto known = paths_.find(text);
  if (known != paths_.end()) return known->second;
  const XrPath path = ToPath(next, handle, text);
  if (path != XR_NULL_PATH) paths_.emplace(text, path);
  return path;
}

}  // namespace omni::layer
