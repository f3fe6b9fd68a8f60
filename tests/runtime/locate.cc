// xrLocateSpace. A shared lock, a few table lookups, arithmetic: no system call.

#include "tests/runtime/locate.h"

#include "tests/runtime/entry_points.h"

namespace omni::runtime {
namespace {

constexpr XrSpaceLocationFlags kValid = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
constexpr XrSpaceLocationFlags kTracked =
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;

Motion ReferenceMotion(const World& world, XrReferenceSpaceType type, XrTime time) {
  switch (type) {
    case XR_REFERENCE_SPACE_TYPE_VIEW:
      return world.HeadAt(time);
    case XR_REFERENCE_SPACE_TYPE_LOCAL: {
      Motion motion;
      motion.pose = world.LocalOriginAt(time);
      return motion;
    }
    default:
      return {};
  }
}

XrSpaceVelocity* VelocityIn(XrSpaceLocation& location) {
  for (auto* next = static_cast<XrBaseOutStructure*>(location.next); next != nullptr; next = next->next) {
    if (next->type == XR_TYPE_SPACE_VELOCITY) return reinterpret_cast<XrSpaceVelocity*>(next);
  }
  return nullptr;
}

}  // namespace

// An action space is locatable while the last sync left its action active, and its device is still there.
Located Locate(const World& world, Session& session, const Space& space, XrTime time) {
  Located result;
  if (space.action == nullptr) {
    result.valid = result.tracked = true;
    result.motion = Attach(ReferenceMotion(world, space.reference, time), space.offset);
    return result;
  }
  Slot* slot = nullptr;
  if (XR_FAILED(FindSlot(session, *space.action, space.subaction, &slot)) || !slot->active) return result;
  if (!world.IsLive(slot->pose_source)) return result;
  const Device& device = world.devices[slot->pose_source.hand];
  result.source = slot->pose_source;
  result.valid = device.valid;
  result.tracked = device.valid && device.tracked;
  result.motion = Attach(world.PoseAt(slot->pose_source, time), space.offset);
  return result;
}

Located LocateIn(const World& world, Session& session, const Space& space, const Space& base, XrTime time) {
  const Located in_world = Locate(world, session, space, time);
  const Located base_in_world = Locate(world, session, base, time);
  Located result;
  const bool joined = in_world.source.hand >= 0 && in_world.source == base_in_world.source;
  if (&space == &base || joined) {
    result.valid = result.tracked = true;
    result.motion.pose = Normalized(Compose(Inverse(base.offset), space.offset));
    return result;
  }
  result.valid = in_world.valid && base_in_world.valid;
  result.tracked = in_world.tracked && base_in_world.tracked;
  if (result.valid) result.motion = Relative(base_in_world.motion, in_world.motion);
  return result;
}

XrResult LocateSpace(XrSpace space, XrSpace base_space, XrTime time, XrSpaceLocation* location) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Space, found, space);
  OMNI_FIND(Space, base, base_space);
  OMNI_REQUIRE(Is(location, XR_TYPE_SPACE_LOCATION), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(found->session == base->session, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(time > 0, XR_ERROR_TIME_INVALID);
  const Located result = LocateIn(state.world, *found->session, *found, *base, time);
  location->locationFlags = (result.valid ? kValid : 0) | (result.tracked ? kTracked : 0);
  location->pose = result.motion.pose;
  if (XrSpaceVelocity* const velocity = VelocityIn(*location); velocity != nullptr) {
    velocity->velocityFlags =
        result.valid ? XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT : 0;
    velocity->linearVelocity = result.motion.linear_m_s;
    velocity->angularVelocity = result.motion.angular_rad_s;
  }
  return XR_SUCCESS;
}

}  // namespace omni::runtime
