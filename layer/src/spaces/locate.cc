#include "layer/src/spaces/locate.h"

namespace omni::layer {
namespace {

bool All(XrFlags64 flags, XrFlags64 bits) { return (flags & bits) == bits; }

// Position of C in A needs all of AB and the position of BC; orientation needs both orientations.
XrSpaceLocationFlags ChainBits(XrSpaceLocationFlags parent, XrSpaceLocationFlags child, XrSpaceLocationFlags position,
                               XrSpaceLocationFlags orientation) {
  XrSpaceLocationFlags out = 0;
  if (All(parent, orientation) && All(child, orientation)) out |= orientation;
  if (All(parent, position | orientation) && All(child, position)) out |= position;
  return out;
}

}  // namespace

Located Compose(const Located& X_AB, const Located& X_BC) noexcept {
  Located out;
  out.motion = Compose(X_AB.motion, X_BC.motion);
  out.flags =
      ChainBits(X_AB.flags, X_BC.flags, XR_SPACE_LOCATION_POSITION_VALID_BIT, XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) |
      ChainBits(X_AB.flags, X_BC.flags, XR_SPACE_LOCATION_POSITION_TRACKED_BIT,
                XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT);
  const XrSpaceVelocityFlags both = X_AB.velocity_flags & X_BC.velocity_flags;
  if (All(X_AB.flags, XR_SPACE_LOCATION_ORIENTATION_VALID_BIT)) {
    out.velocity_flags |= both & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;
    if (All(X_AB.velocity_flags, XR_SPACE_VELOCITY_ANGULAR_VALID_BIT) &&
        All(X_BC.flags, XR_SPACE_LOCATION_POSITION_VALID_BIT))
      out.velocity_flags |= both & XR_SPACE_VELOCITY_LINEAR_VALID_BIT;
  }
  return out;
}

Located Inverse(const Located& X_AB) noexcept {
  Located out;
  out.motion = Inverse(X_AB.motion);
  out.flags =
      ChainBits(X_AB.flags, X_AB.flags, XR_SPACE_LOCATION_POSITION_VALID_BIT, XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) |
      ChainBits(X_AB.flags, X_AB.flags, XR_SPACE_LOCATION_POSITION_TRACKED_BIT,
                XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT);
  if (All(X_AB.velocity_flags, kVelocityValid) && All(X_AB.flags, kValid)) {
    out.velocity_flags = kVelocityValid;
  } else if (All(X_AB.flags, XR_SPACE_LOCATION_ORIENTATION_VALID_BIT)) {
    out.velocity_flags = X_AB.velocity_flags & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;
  }
  return out;
}

Motion KnownMotion(const Located& X_AB) noexcept {
  Motion m = X_AB.motion;
  if (!(X_AB.velocity_flags & XR_SPACE_VELOCITY_LINEAR_VALID_BIT)) m.v = glm::dvec3(0.0);
  if (!(X_AB.velocity_flags & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT)) m.w = glm::dvec3(0.0);
  return m;
}

Located PenIn(const Motion& X_LO, const ToolMotion& tool, const Pose& X_TS) noexcept {
  Located out;
  if (!tool.valid) return out;
  Motion offset;
  offset.X = X_TS;
  out.motion = Compose(Compose(X_LO, tool.X_BT), offset);
  out.flags = tool.tracked ? kValid | kTracked : kValid;
  out.velocity_flags = kVelocityValid;
  return out;
}

Located Read(const LocationFields& location, const VelocityFields& velocity) noexcept {
  Located out;
  out.flags = *location.flags;
  if (out.flags & kValid) out.motion.X = FromXr(*location.pose);
  if (!velocity.flags) return out;
  out.velocity_flags = *velocity.flags;
  if (out.velocity_flags & XR_SPACE_VELOCITY_LINEAR_VALID_BIT) out.motion.v = FromXr(*velocity.linear);
  if (out.velocity_flags & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT) out.motion.w = FromXr(*velocity.angular);
  return out;
}

void WriteLocation(const Located& located, const LocationFields& location, const VelocityFields& velocity) noexcept {
  const XrPosef pose = ToXr(located.motion.X);
  *location.flags = located.flags;
  *location.pose = {{0, 0, 0, 1}, {0, 0, 0}};
  if (located.flags & XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) location.pose->orientation = pose.orientation;
  if (located.flags & XR_SPACE_LOCATION_POSITION_VALID_BIT) location.pose->position = pose.position;
  if (!velocity.flags) return;
  *velocity.flags = located.velocity_flags;
  *velocity.linear = *velocity.angular = {0, 0, 0};
  if (located.velocity_flags & XR_SPACE_VELOCITY_LINEAR_VALID_BIT) *velocity.linear = ToXr(located.motion.v);
  if (located.velocity_flags & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT) *velocity.angular = ToXr(located.motion.w);
}

}  // namespace omni::layer
