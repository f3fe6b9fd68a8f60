#include "layer/src/instance/runtime.h"

#include <algorithm>
#include <utility>

#include "layer/src/actions/profile.h"

namespace omni::layer {
namespace {

bool Contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> Without(std::vector<std::string> names, const std::vector<std::string>& others) {
  std::erase_if(names, [&](const std::string& name) { return Contains(others, name); });
  return names;
}

XrPath ToPath(const Dispatch& next, XrInstance instance, std::string_view text) {
  XrPath path = XR_NULL_PATH;
  return XR_SUCCEEDED(next.StringToPath(instance, std::string(text).c_str(), &path)) ? path : XR_NULL_PATH;
}

}  // namespace

Runtime::Runtime(XrInstance instance, const Dispatch& functions, std::vector<std::string> enabled,
                 std::vector<std::string> only_ours)
    : handle(instance),
      next(functions),
      hand_paths{ToPath(next, handle, UserPath(Hand::kLeft)), ToPath(next, handle, UserPath(Hand::kRight))},
      enabled_(std::move(enabled)),
      only_ours_(std::move(only_ours)),
      enabled_below_(Without(enabled_, only_ours_)) {}

bool Runtime::HasExtension(std::string_view extension) const { return Contains(enabled_, extension); }

bool Runtime::OnlyOurs(std::string_view extension) const { return Contains(only_ours_, extension); }

std::string Runtime::PathText(XrPath path) const {
  const std::lock_guard lock(path_mutex_);
  const auto known = path_texts_.find(path);
  if (known != path_texts_.end()) return known->second;
  char text[XR_MAX_PATH_LENGTH] = {};
  std::uint32_t length = 0;
  if (path == XR_NULL_PATH || XR_FAILED(next.PathToString(handle, path, sizeof(text), &length, text))) return {};
  return path_texts_.emplace(path, text).first->second;
}

XrPath Runtime::PathOf(const std::string& text) const {
  const std::lock_guard lock(path_mutex_);
  const auto known = paths_.find(text);
  if (known != paths_.end()) return known->second;
  const XrPath path = ToPath(next, handle, text);
  if (path != XR_NULL_PATH) paths_.emplace(text, path);
  return path;
}

}  // namespace omni::layer
