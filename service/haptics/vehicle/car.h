// A tick of the race: stick -> tyres -> path and walls -> laps, and the force on the pen. docs/theory/haptics.md,
// section 8.
#pragma once

#include "service/haptics/vehicle/car_motion.h"
#include "service/haptics/vehicle/joystick.h"

namespace omni::haptics {

// At its start, at rest, no lap begun.
void StartCar(const VehicleInput& car, VehicleState& state) noexcept;

// One tick of driving on the plane z = start.z.
Impacts DriveCar(const VehicleInput& car, const WallMap& walls, std::span<const Material> materials,
                 const Thumbstick& stick, double dt_s, VehicleState& state) noexcept;

// Joystick and car of a scene: force on the pen. `contacts_N`: other forces on the pen. Fills the joystick's and the
// vehicle's part of `output`.
Vec3 StepVehicle(const Config& config, const StiffnessBound& bound, const Scene& scene, const Input& input,
                 const Vec3& contacts_N, State& state, Output& output) noexcept;

}  // namespace omni::haptics
