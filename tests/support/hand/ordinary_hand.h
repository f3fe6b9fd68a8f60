// A hand that does what people do with a pen, drawn by a seed.
#pragma once

#include <cstdint>

#include "service/base/device_geometry.h"
#include "service/sim/twin/twin.h"

namespace omni::sim {

// A person who works with the pen: moves, stops, taps the hull, rests, and lays the pen on the hull
// now and then.
struct OrdinaryHandOptions {
  std::uint64_t seed = 1;
  double duration_s = 60;
  double radius_max_m = 0.09;  // of the magnet's centre
  double tilt_max_rad = 0.7853981633974483;
  double speed_min_m_s = 0.1, speed_max_m_s = 0.5;  // greatest of a movement
  double tremor_m = 0.1e-3;
  double above_s = 0;  // at first, at rest above the base with the tip down, as the hands of the shipped scenes begin
};

HandScript MakeOrdinaryHand(const base::DeviceGeometry& device, const OrdinaryHandOptions& options);

}  // namespace omni::sim
