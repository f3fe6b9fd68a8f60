// XR_EXT_conformance_automation for both controllers, where a test wants it (OMNI_TEST_RUNTIME_AUTOMATION): what the
// hooks do, from inside of an application.

#include <cmath>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/spaces/locate.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

// A component of a hand's device: `set` gets its full path.
template <class Set>
XrResult SetComponent(XrSession session, XrPath top_level, XrPath source, Set set) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  const Instance& instance = *owner->instance;
  const std::string* const path = PathText(instance, source);
  OMNI_REQUIRE(path != nullptr && PathText(instance, top_level) != nullptr, XR_ERROR_PATH_INVALID);
  const int hand = HandOf(instance, top_level);
  OMNI_REQUIRE(hand >= 0 && SplitHandPath(*path).hand == hand, XR_ERROR_PATH_UNSUPPORTED);
  return set(state.world, *owner, *path);
}

XrResult Done(bool known) { return known ? XR_SUCCESS : XR_ERROR_PATH_UNSUPPORTED; }

}  // namespace

XrResult SetInputDeviceActiveEXT(XrSession session, XrPath profile, XrPath top_level, XrBool32 active) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  const std::string* const name = PathText(*owner->instance, profile);
  OMNI_REQUIRE(name != nullptr && PathText(*owner->instance, top_level) != nullptr, XR_ERROR_PATH_INVALID);
  const int hand = HandOf(*owner->instance, top_level);
  OMNI_REQUIRE(hand >= 0, XR_ERROR_PATH_UNSUPPORTED);
  return Done(state.world.RenewDevice(hand, active != XR_FALSE, *name));
}

XrResult SetInputDeviceStateBoolEXT(XrSession session, XrPath top_level, XrPath source, XrBool32 value) {
  return SetComponent(session, top_level, source, [value](World& world, Session&, const std::string& path) {
    return Done(world.SetBool(path, value != XR_FALSE));
  });
}

XrResult SetInputDeviceStateFloatEXT(XrSession session, XrPath top_level, XrPath source, float value) {
  OMNI_REQUIRE(std::isfinite(value), XR_ERROR_VALIDATION_FAILURE);
  return SetComponent(session, top_level, source, [value](World& world, Session&, const std::string& path) {
    return Done(world.SetFloat(path, value));
  });
}

XrResult SetInputDeviceStateVector2fEXT(XrSession session, XrPath top_level, XrPath source, XrVector2f value) {
  OMNI_REQUIRE(std::isfinite(value.x) && std::isfinite(value.y), XR_ERROR_VALIDATION_FAILURE);
  return SetComponent(session, top_level, source, [value](World& world, Session&, const std::string& path) {
    return Done(world.SetVector2(path, value.x, value.y));
  });
}

XrResult SetInputDeviceLocationEXT(XrSession session, XrPath top_level, XrPath source, XrSpace space, XrPosef pose) {
  OMNI_REQUIRE(IsValid(pose), XR_ERROR_POSE_INVALID);
  return SetComponent(session, top_level, source, [&](World& world, Session& owner, const std::string& path) {
    OMNI_FIND(Space, in, space);
    OMNI_REQUIRE(in->session == &owner, XR_ERROR_VALIDATION_FAILURE);
    const Located located = Locate(world, owner, *in, Now());
    OMNI_REQUIRE(located.valid, XR_ERROR_RUNTIME_FAILURE);
    Motion motion;
    motion.pose = Compose(located.motion.pose, pose);
    return Done(world.SetPose(path, motion));
  });
}

}  // namespace omni::runtime
