#include "layer/src/instance/instance.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "layer/src/entry/own_names.h"
#include "service/base/clock.h"
#include "service/protocol/environment.h"

namespace omni::layer {
namespace {

std::optional<Hand> FixedHand(Log& log) {
  const std::string hand = protocol::Environment("OMNI_HAND");
  if (hand.empty()) return std::nullopt;
  if (hand == "right") return Hand::kRight;
  if (hand == "left") return Hand::kLeft;
  log.Line("OMNI_HAND=" + hand + " is neither left nor right: ignored");
  return std::nullopt;
}

std::string FixedProfile(const std::vector<Profile>& profiles, Log& log) {
  const std::string name = protocol::Environment("OMNI_PROFILE");
  if (name.empty()) return {};
  std::string path = FullProfilePath(name);
  const bool known = std::any_of(profiles.begin(), profiles.end(), [&](const Profile& p) { return p.path == path; });
  if (!known) log.Line("OMNI_PROFILE=" + name + " is not a known profile: ignored");
  return known ? path : std::string();
}

std::vector<std::string> Without(std::vector<std::string> names, const std::vector<std::string>& others) {
  names.erase(std::remove_if(names.begin(), names.end(),
                             [&](const std::string& name) {
                               return std::find(others.begin(), others.end(), name) != others.end();
                             }),
              names.end());
  return names;
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
      hide_presence(setup.hide_presence),
      profiles(LoadProfiles()),
      hand_paths{ToPath(setup.next, setup.handle, UserPath(Hand::kLeft)),
                 ToPath(setup.next, setup.handle, UserPath(Hand::kRight))},
      clock(setup.handle, setup.next.ConvertTimespecTimeToTimeKHR),
      link(std::move(setup.connection), log),
      enabled_(std::move(setup.enabled)),
      only_ours_(std::move(setup.only_ours)),
      enabled_below_(Without(enabled_, only_ours_)),
      fixed_hand_(FixedHand(log)),
      fixed_profile_(FixedProfile(profiles, log)) {
  if (Enabled(XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME) && TestDevice::Wanted())
    link.UseTestDevice(std::make_unique<TestDevice>());
  const std::int64_t now = base::MonotonicNow_ns();
  clock.Refresh(now);
  link.Poll(now);
}

XrResult Instance::ResultToString(XrResult value, char* buffer) {
  link.Beat();
  const char* name = OwnName(value);
  if (!name || !buffer) return next.ResultToString(handle, value, buffer);
  std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s", name);
  return XR_SUCCESS;
}

XrResult Instance::StructureTypeToString(XrStructureType value, char* buffer) {
  link.Beat();
  const char* name = OwnName(value);
  if (!name || !buffer) return next.StructureTypeToString(handle, value, buffer);
  std::snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "%s", name);
  return XR_SUCCESS;
}

bool Instance::Enabled(std::string_view extension) const {
  return std::find(enabled_.begin(), enabled_.end(), extension) != enabled_.end();
}

PenChoice Instance::Choice() const {
  const protocol::AppSettings wished = link.settings();
  PenChoice choice;
  choice.hand = fixed_hand_.value_or(wished.hand == protocol::HandSetting::kLeft ? Hand::kLeft : Hand::kRight);
  choice.profile = fixed_profile_.empty() ? std::string(wished.profile) : fixed_profile_;
  return choice;
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
