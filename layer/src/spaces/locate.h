// The algebra of xrLocateSpace: motions with the spec's validity bits.
#pragma once

#include "layer/src/spaces/base_pose.h"
#include "layer/src/spaces/tool_motion.h"

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

Located Compose(const Located& X_AB, const Located& X_BC) noexcept;
Located Inverse(const Located& X_AB) noexcept;

// Pose and velocity as far as they are known; an unknown velocity is zero.
Motion KnownMotion(const Located& X_AB) noexcept;

// A space fixed to the pen, in L.
Located PenIn(const Motion& X_LO, const ToolMotion& tool, const Pose& X_TS) noexcept;

// OpenXR has four structures for a located thing (one space, one of many, a joint, all views); these are their parts.
struct LocationFields {
  XrSpaceLocationFlags* flags;
  XrPosef* pose;
};
struct VelocityFields {  // all null: not requested
  XrSpaceVelocityFlags* flags = nullptr;
  XrVector3f* linear = nullptr;
  XrVector3f* angular = nullptr;
};
template <class Velocity>
VelocityFields FieldsOf(Velocity* velocity) noexcept {
  if (!velocity) return {};
  return {&velocity->velocityFlags, &velocity->linearVelocity, &velocity->angularVelocity};
}

Located Read(const LocationFields& location, const VelocityFields& velocity) noexcept;

// Writes pose, flags and velocity. What is not valid is zero (unit rotation).
void WriteLocation(const Located& located, const LocationFields& location, const VelocityFields& velocity) noexcept;

// The structure of that type in an output chain, or null.
template <class Structure>
Structure* FindInChain(void* next, XrStructureType type) noexcept {
  auto* chain = static_cast<XrBaseOutStructure*>(next);
  while (chain && chain->type != type) chain = chain->next;
  return static_cast<Structure*>(static_cast<void*>(chain));
}

}  // namespace omni::layer
