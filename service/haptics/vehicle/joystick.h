// Joystick: the tip is pulled to a centre, over notches if there are any; its displacement is the thumbstick.
// docs/theory/haptics.md, section 7.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/scene/scene_input.h"
#include "service/haptics/stability/stability.h"

namespace omni::haptics {

using base::Vec3;

struct Thumbstick {
  double x = 0, y = 0;  // length <= 1
};

// Spring, damping and notches at input.device_point_base_m. `detent_curvature_N_m`: what DetentCurvature_N_m returned.
Vec3 JoystickForce(const JoystickInput& joystick, double detent_curvature_N_m, const StiffnessBound& bound,
                   const Input& input) noexcept;
Thumbstick JoystickDeflection(const JoystickInput& joystick, const Vec3& tip) noexcept;

// Force of the notches alone, unscaled, in the plane; conservative. `u`: tip - centre.
Vec3 DetentForce(const JoystickInput& joystick, const Vec3& u) noexcept;
// Stiffest direction of that force over all places: set-up only, the tick scales the notches by it.
double DetentCurvature_N_m(const JoystickInput& joystick);

}  // namespace omni::haptics
