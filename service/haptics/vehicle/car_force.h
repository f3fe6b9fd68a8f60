// Forces of the car on the pen. Pulses of hits: half sines, stronger for faster hits, together never more than the
// device can do. The hum of the engine and the ripple of the road: straight up and down, so that they do not steer.
// docs/theory/haptics.md, section 8.
#pragma once

#include "service/base/force_limit.h"
#include "service/haptics/scene/scene_input.h"
#include "service/haptics/state.h"
#include "service/haptics/vehicle/car_motion.h"

namespace omni::haptics {

// How much force along `direction` (unit) still fits on top of `others_N`: largest s >= 0 such that others + s
// direction is feasible. 0 if the limit is invalid or `others_N` alone is not feasible.
double Headroom_N(const base::ForceLimit& limit, const Vec3& others_N, const Vec3& direction) noexcept;

// Where a hit of a wall with this normal pushes the pen at `tip`: d = (1 - h) n + h c, normalised, c the direction of
// the base's centre, h the share of the tag   (8.11). Unit.
Vec3 HitDirection(const VehicleInput& car, const Vec3& normal, const Vec3& tip) noexcept;

struct PulseLimits {
  const base::ForceLimit& device;
  Vec3 others_N;  // other forces rendered
  double slew_N_s = 0;
};

// Peak of the pulse of a hit: J = F_max (1 - exp(-(1 + e) v / hit_speed)), strictly growing with the speed v   (8.10).
// F_max   (8.9): what the vehicle requests, what the device can do here, and what the slew limit lets a half sine be.
double PulseAmplitude_N(const VehicleInput& car, const PulseLimits& limits, const Impact& impact) noexcept;

void StartPulses(const VehicleInput& car, const PulseLimits& limits, const Impacts& impacts,
                 VehicleState& state) noexcept;

struct PulseForce {
  Vec3 force_N;
  double share = 0;  // [0, 1]: how near its peak the strongest pulse is; other ripple gives way to it
};

// All running pulses; advances their clocks.
PulseForce AdvancePulses(const VehicleInput& car, const PulseLimits& limits, double dt_s, VehicleState& state) noexcept;

inline constexpr double kRoadForceMax_N = 0.1;
inline constexpr double kRoadForceMax_Hz = 150;

// Force along +z, at most 0.1 N, nothing over 150 Hz, none at rest; advances the phases.
double RoadForce_N(const VehicleInput& car, double dt_s, VehicleState& state) noexcept;

}  // namespace omni::haptics
