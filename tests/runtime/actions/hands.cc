// XR_EXT_hand_tracking: a stiff hand. Its joints are fixed to the palm, so that a test can compute them.

#include <cmath>
#include <mutex>
#include <shared_mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/spaces/locate.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

constexpr float kJointRadius_m = 0.008f;

// Each joint further along -Z, and turned a little more about +Y: no two are alike.
XrPosef JointInPalm(uint32_t joint) {
  const float n = static_cast<float>(joint);
  return {{0, std::sin(0.02f * n), 0, std::cos(0.02f * n)}, {0.002f * n, 0.001f * n, -0.005f * n}};
}

void FillJoint(const Located& located, XrHandJointLocationEXT& out) {
  constexpr XrSpaceLocationFlags kAll = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                                        XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT |
                                        XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
  out.locationFlags = located.valid ? kAll : 0;
  out.pose = located.motion.pose;
  out.radius = kJointRadius_m;
}

void FillJointVelocity(const World& world, const Located& located, XrHandJointVelocityEXT& out) {
  const bool known = located.valid && world.has_velocities;
  out.velocityFlags = known ? XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT : 0;
  out.linearVelocity = known ? located.motion.linear_m_s : XrVector3f{0, 0, 0};
  out.angularVelocity = known ? located.motion.angular_rad_s : XrVector3f{0, 0, 0};
}

}  // namespace

XrResult CreateHandTrackerEXT(XrSession session, const XrHandTrackerCreateInfoEXT* info, XrHandTrackerEXT* tracker) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT) && tracker != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->hand == XR_HAND_LEFT_EXT || info->hand == XR_HAND_RIGHT_EXT, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->handJointSet == XR_HAND_JOINT_SET_DEFAULT_EXT, XR_ERROR_VALIDATION_FAILURE);
  auto created = std::make_shared<HandTracker>();
  created->session = owner;
  created->hand = info->hand == XR_HAND_LEFT_EXT ? 0 : 1;
  *tracker = AddChild<XrHandTrackerEXT>(state, *owner, std::move(created));
  return XR_SUCCESS;
}

XrResult DestroyHandTrackerEXT(XrHandTrackerEXT tracker) { return DestroyChild<HandTracker>(tracker); }

XrResult LocateHandJointsEXT(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT* info,
                             XrHandJointLocationsEXT* out) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(HandTracker, found, tracker);
  OMNI_REQUIRE(Is(info, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(Is(out, XR_TYPE_HAND_JOINT_LOCATIONS_EXT), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(out->jointCount == XR_HAND_JOINT_COUNT_EXT && out->jointLocations != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  auto* const velocities = InChain<XrHandJointVelocitiesEXT>(out->next, XR_TYPE_HAND_JOINT_VELOCITIES_EXT);
  OMNI_REQUIRE(velocities == nullptr ||
                   (velocities->jointCount == XR_HAND_JOINT_COUNT_EXT && velocities->jointVelocities != nullptr),
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(Space, base, info->baseSpace);
  OMNI_REQUIRE(base->session == found->session, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->time > 0, XR_ERROR_TIME_INVALID);
  const Located in_world = Locate(state.world, *found->session, *base, info->time);
  out->isActive = state.world.hands[found->hand].active ? XR_TRUE : XR_FALSE;
  for (uint32_t i = 0; i < XR_HAND_JOINT_COUNT_EXT; ++i) {
    Located joint;
    joint.valid = out->isActive && in_world.valid;
    if (joint.valid)
      joint.motion = Relative(in_world.motion, Attach(state.world.PalmAt(found->hand, info->time), JointInPalm(i)));
    FillJoint(joint, out->jointLocations[i]);
    if (velocities != nullptr) FillJointVelocity(state.world, joint, velocities->jointVelocities[i]);
  }
  return XR_SUCCESS;
}

}  // namespace omni::runtime
