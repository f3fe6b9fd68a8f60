// Joystick: the tip is drawn to a centre, its displacement is the thumbstick. docs/theory/haptics.md, section 7.
#pragma once

#include "service/haptics/geometry/vec_math.h"
#include "service/haptics/stability.h"

namespace omni::haptics {

struct Thumbstick {
  double x = 0, y = 0;  // length <= 1
};

Vec3 JoystickForce(const JoystickInput& joystick, const Offer& offer, const Input& input) noexcept;
Thumbstick JoystickDeflection(const JoystickInput& joystick, const Vec3& tip) noexcept;

}  // namespace omni::haptics
