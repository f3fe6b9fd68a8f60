// A car on the plane z = start.z: kinematic bicycle, walls it cannot pass, a pulse on the pen when it hits one.
// docs/theory/haptics.md, section 8.
#pragma once

#include "service/haptics/geometry/surface.h"
#include "service/haptics/vehicle/joystick.h"

namespace omni::haptics {

void StartCar(const VehicleInput& car, VehicleState& state) noexcept;

// One tick of driving: +y accelerates, -y brakes and then reverses, +x turns right.
void DriveCar(const VehicleInput& car, const Scene& scene, const Surface& surface, const Thumbstick& stick, double dt_s,
              VehicleState& state) noexcept;

// Moves the car by `speed * dt` along its heading, stopping or sliding at walls. Never passes a wall at any speed.
void MoveCar(const VehicleInput& car, const Scene& scene, const Surface& surface, double dt_s,
             VehicleState& state) noexcept;

// The running hit pulse on the pen; advances its clock.
Vec3 PulseForce(const VehicleInput& car, double dt_s, VehicleState& state) noexcept;

}  // namespace omni::haptics
