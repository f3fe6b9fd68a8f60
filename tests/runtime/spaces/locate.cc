// xrLocateSpace, xrLocateSpaces. A shared lock, a few table lookups, arithmetic: no system call.

#include "tests/runtime/spaces/locate.h"

#include "tests/runtime/entry_points.h"

namespace omni::runtime {
namespace {

constexpr XrSpaceLocationFlags kValid = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
constexpr XrSpaceLocationFlags kTracked =
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;

Motion ReferenceMotion(const World& world, XrReferenceSpaceType type, XrTime time) {
  if (type == XR_REFERENCE_SPACE_TYPE_VIEW) return world.HeadAt(time);
  Motion motion;
  motion.pose = world.OriginAt(type, time);
  return motion;
}

// XrSpaceLocation and XrSpaceLocationData, XrSpaceVelocity and XrSpaceVelocityData have the same members.
template <class Location>
void FillLocation(const Located& located, Location& out) {
  out.locationFlags = (located.valid ? kValid : 0) | (located.tracked ? kTracked : 0);
  out.pose = located.motion.pose;
}

template <class Velocity>
void FillVelocity(const World& world, const Located& located, Velocity& out) {
  const bool known = located.valid && world.has_velocities;
  out.velocityFlags = known ? XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT : 0;
  out.linearVelocity = known ? located.motion.linear_m_s : XrVector3f{0, 0, 0};
  out.angularVelocity = known ? located.motion.angular_rad_s : XrVector3f{0, 0, 0};
}

// Both names of xrLocateSpaces.
XrResult LocateMany(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* out) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_SPACES_LOCATE_INFO) && Is(out, XR_TYPE_SPACE_LOCATIONS), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->spaceCount > 0 && info->spaces != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(out->locationCount == info->spaceCount && out->locations != nullptr, XR_ERROR_VALIDATION_FAILURE);
  auto* const velocities = InChain<XrSpaceVelocities>(out->next, XR_TYPE_SPACE_VELOCITIES);
  OMNI_REQUIRE(
      velocities == nullptr || (velocities->velocityCount == info->spaceCount && velocities->velocities != nullptr),
      XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(Space, base, info->baseSpace);
  OMNI_REQUIRE(base->session == owner, XR_ERROR_VALIDATION_FAILURE);
  for (uint32_t i = 0; i < info->spaceCount; ++i) {
    OMNI_FIND(Space, space, info->spaces[i]);
    OMNI_REQUIRE(space->session == owner, XR_ERROR_VALIDATION_FAILURE);
  }
  OMNI_REQUIRE(info->time > 0, XR_ERROR_TIME_INVALID);
  for (uint32_t i = 0; i < info->spaceCount; ++i) {
    const Space& space = *state.handles.Find<Space>(info->spaces[i]);
    const Located located = LocateIn(state.world, *owner, space, *base, info->time);
    FillLocation(located, out->locations[i]);
    if (velocities != nullptr) FillVelocity(state.world, located, velocities->velocities[i]);
  }
  return XR_SUCCESS;
}

}  // namespace

// An action space is locatable while the last sync left its action active, and its device is still there.
Located Locate(const World& world, Session& session, const Space& space, XrTime time) {
  Located result;
  if (space.model != nullptr) {
    const int hand = space.model->hand;
    const int grip = FindComponent(Profiles()[world.devices[hand].profile], hand, "input/grip/pose");
    result.valid = result.tracked = grip >= 0 && IsShown(*space.model);
    if (result.valid) result.motion = world.PoseAt({hand, grip, world.devices[hand].epoch}, time);
    return result;
  }
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
  FillLocation(result, *location);
  auto* const velocity = InChain<XrSpaceVelocity>(location->next, XR_TYPE_SPACE_VELOCITY);
  if (velocity != nullptr) FillVelocity(state.world, result, *velocity);
  return XR_SUCCESS;
}

XrResult LocateSpaces(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* out) {
  return LocateMany(session, info, out);
}

XrResult LocateSpacesKHR(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* out) {
  return LocateMany(session, info, out);
}

}  // namespace omni::runtime
