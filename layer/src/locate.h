// The algebra of xrLocateSpace: motions with the spec's validity bits.
#pragma once

#include "layer/src/pose_math.h"
#include "layer/src/tool_motion.h"

namespace omni::layer {

struct Located {
  Motion motion;
  XrSpaceLocationFlags flags = 0;
  XrSpaceVelocityFlags velocity_flags = 0;
};

inline constexpr XrSpaceLocationFlags kValid =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
inline constexpr XrSpaceLocationFlags kTracked =
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
inline constexpr XrSpaceVelocityFlags kVelocityValid =
    XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;

// Where the base stands when nobody has aligned it: in front of the user of LOCAL, below the eyes, its +y away from
// the user. O: base, z up; L: LOCAL, y up.
Pose DefaultPlacement();

Located Chain(const Located& X_AB, const Located& X_BC) noexcept;
Located Invert(const Located& X_AB) noexcept;

// A space fixed to the pen, in LOCAL.
Located PenIn(const Pose& X_LO, const ToolMotion& tool, const Pose& X_TS) noexcept;

// Writes pose, flags and, if chained, the velocity. What is not valid is zero (unit rotation).
void Write(const Located& located, XrSpaceLocation& location) noexcept;

// The XrSpaceVelocity chained to a location, or null.
XrSpaceVelocity* ChainedVelocity(const XrSpaceLocation& location) noexcept;

}  // namespace omni::layer
