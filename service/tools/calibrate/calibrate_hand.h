// The hand that calibrates the twin: a scripted person of the simulation, who takes the pen away, waves it and touches
// the hull as `omni calibrate` instructs.
#pragma once

#include <cstdint>

#include "service/base/device_geometry.h"
#include "service/sim/twin/twin.h"

namespace omni::tools {

struct CalibratingHand {
  double away_s = 6;  // pen out of reach: the coil sweep
  double wave_s = 22;
  int touches = 130;
  std::uint64_t seed = 1;
};

sim::HandScript MakeCalibratingHand(const base::DeviceGeometry& device, const CalibratingHand& options);

// Rests the tip in a dimple and swings the pen about it: `omni calibrate --tip`.
struct PivotingHand {
  base::Vec3 dimple_base_m{0, -0.07, 0.01};
  double rest_s = 1;      // upright, before it is leaned
  double tilt_rad = 0.6;  // greatest, from upright
  double swing_s = 12;
  std::uint64_t seed = 1;
};

sim::HandScript MakePivotingHand(const PivotingHand& options);

}  // namespace omni::tools
