// The hum of the engine and the ripple of the road, straight up and down, so that they do not steer.
// docs/theory/haptics.md, section 8.
#pragma once

#include "service/haptics/scene/scene_input.h"
#include "service/haptics/state.h"

namespace omni::haptics {

inline constexpr double kRoadForceMax_N = 0.1;
inline constexpr double kRoadForceMax_Hz = 150;

// Force along +z, at most 0.1 N, nothing over 150 Hz, none at rest; advances the phases.
double RoadForce_N(const VehicleInput& car, double dt_s, VehicleState& state) noexcept;

}  // namespace omni::haptics
