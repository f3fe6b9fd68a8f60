#include "layer/src/instance/instance.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "layer/src/entry/own_extensions.h"
#include "service/base/clock.h"
#include "service/protocol/environment.h"

namespace omni::layer {
namespace {

std::optional<Hand> FixedHand(Log& log) {
  const std::string hand = protocol::EnvironmentVariable("OMNI_HAND");
  if (hand.empty()) return std::nullopt;
  if (hand == "right") return Hand::kRight;
  if (hand == "left") return Hand::kLeft;
  log.WriteLine("OMNI_HAND=" + hand + " is neither left nor right: ignored");
  return std::nullopt;
}

std::string FixedProfile(const std::vector<Profile>& profiles, Log& log) {
  const std::string name = protocol::EnvironmentVariable("OMNI_PROFILE");
  if (name.empty()) return {};
  std::string path = FullProfilePath(name);
  const bool known = std::any_of(profiles.begin(), profiles.end(), [&](const Profile& p) { return p.path == path; });
  if (!known) log.WriteLine("OMNI_PROFILE=" + name + " is not a known profile: ignored");
  return known ? path : std::string();
}

}  // namespace

Instance::Instance(InstanceSetup setup)
    : runtime(setup.handle, setup.next, std::move(setup.enabled), std::move(setup.only_ours)),
      hide_timespec(setup.hide_timespec),
      hide_presence(setup.hide_presence),
      profiles(LoadProfiles()),
      clock(setup.handle, setup.next.ConvertTimespecTimeToTimeKHR),
      link(std::move(setup.connection), log) {
  link.Fix(FixedHand(log), FixedProfile(profiles, log));
  if (runtime.HasExtension(XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME) && TestDevice::IsEnabled())
    link.UseTestDevice(std::make_unique<TestDevice>());
  const std::int64_t now = base::MonotonicNow_ns();
  clock.Refresh(now);
  link.Poll(now);
}

XrResult Instance::ResultToString(XrResult value, char* buffer) {
  link.SignalAlive();
  const char* name = OwnName(value);
  if (!name || !buffer) return runtime.next.ResultToString(runtime.handle, value, buffer);
  std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s", name);
  return XR_SUCCESS;
}

XrResult Instance::StructureTypeToString(XrStructureType value, char* buffer) {
  link.SignalAlive();
  const char* name = OwnName(value);
  if (!name || !buffer) return runtime.next.StructureTypeToString(runtime.handle, value, buffer);
  std::snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "%s", name);
  return XR_SUCCESS;
}

}  // namespace omni::layer
