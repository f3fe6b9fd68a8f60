// Tyres, engine and brakes: velocity and yaw rate of the car over a tick. A dynamic bicycle with brush tyres, solved
// implicitly, so that it is sound at every speed down to rest, where it becomes the kinematic one.
// docs/theory/haptics.md, section 8.
#pragma once

#include "service/haptics/scene/scene_input.h"
#include "service/haptics/state.h"
#include "service/haptics/vehicle/joystick.h"

namespace omni::haptics {

inline constexpr double kGravity_m_s2 = 9.80665;

// Share of the full grip that a tyre uses at `slip` = slip stiffness * tan(slip angle) / grip: s - s^2/3 + s^3/27 up to
// s = 3, then 1   (8.2)
double BrushTyre(double slip) noexcept;

// Advances velocity, heading, yaw rate and `sliding` by `dt_s`; the place stays. +y of the stick accelerates, -y brakes
// and then reverses, +x steers right.
void Accelerate(const VehicleInput& car, const Thumbstick& stick, double dt_s, VehicleState& state) noexcept;

// k^2 = inertia a b
double GyrationSquared_m2(const VehicleInput& car) noexcept;

}  // namespace omni::haptics
