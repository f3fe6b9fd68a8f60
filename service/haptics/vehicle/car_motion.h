// How the car moves in a tick. docs/theory/haptics.md, section 8.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/scene/scene_input.h"
#include "service/haptics/state.h"
#include "service/haptics/vehicle/joystick.h"
#include "service/haptics/vehicle/wall_map.h"

namespace omni::haptics {

using base::Vec3;

// Tyres, engine and brakes: velocity and yaw rate of the car over a tick (car_dynamics.cc). A dynamic bicycle with
// brush tyres, solved implicitly, so that it is sound at every speed down to rest, where it becomes the kinematic one.
inline constexpr double kGravity_m_s2 = 9.80665;

// Share of the full grip that a tyre uses at `slip` = slip stiffness * tan(slip angle) / grip: s - s^2/3 + s^3/27 up to
// s = 3, then 1   (8.2)
double BrushTyre(double slip) noexcept;

// Advances velocity, heading, yaw rate and `sliding` by `dt_s`; the place stays. +y of the stick accelerates, -y brakes
// and then reverses, +x steers right.
void Accelerate(const VehicleInput& car, const Thumbstick& stick, double dt_s, VehicleState& state) noexcept;

// k^2 = inertia a b
double GyrationSquared_m2(const VehicleInput& car) noexcept;

// Where it goes: straight on until a wall, then off it or along it, as often as it takes. It never passes a wall, at
// any speed.
inline constexpr int kMaxImpacts = 4;  // rendered in one tick; further ones are only counted

struct Impact {
  double speed_m_s = 0;  // into the wall
  Vec3 normal;           // unit, away from the wall
  double restitution = 0;
};

struct Impacts {
  int count = 0;
  std::array<Impact, kMaxImpacts> of;
};

// Moves the car by its velocity. Walls take out the part into them (give back `restitution` of it at a hit), and turn
// the nose along the wall; energy is never gained. A wall it leans on already is no further hit.
Impacts MoveCar(const VehicleInput& car, const WallMap& walls, std::span<const Material> materials, double dt_s,
                VehicleState& state) noexcept;

// Laps that cannot be cheated, timed to a fraction of a tick (lap_timer.cc).

// The car went straight from `before` to `after` in dt_s. A lap is: over the start line in its direction, then every
// checkpoint in its direction and order, then over the start line again. A checkpoint or start line crossed backwards
// is undone, so that turning round gains nothing.
void AdvanceLap(const VehicleInput& car, const Vec3& before, const Vec3& after, double dt_s, LapState& lap) noexcept;

}  // namespace omni::haptics
