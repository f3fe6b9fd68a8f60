// TickConfig from a device's geometry: everything the tick reads is prepared here, off the tick.
#pragma once

#include "service/base/calibration.h"
#include "service/base/device_geometry.h"
#include "service/loop/tick.h"

namespace omni::loop {

inline TickConfig MakeTickConfig(const base::DeviceGeometry& device, const tracker::Config& tracker,
                                 const actuation::Config& actuation) {
  TickConfig config;
  config.tracker = tracker;
  config.actuation = actuation;
  config.tip_offset_m = device.magnet.tip_offset_m;
  config.applied.force_slew_N_s = config.haptics.force_slew_N_s;
  config.applied.force_max_N = device.force_max_N;
  const actuation::HeatConfig& heat = actuation.heat;
  for (std::size_t k = 0; k < config.cold_current_A.size(); ++k) {
    config.cold_current_A[k] = actuation::CurrentCeiling_A(heat, k, heat.nodes.air_C, heat.nodes.air_C);
  }
  return config;
}

// As drawn.
inline TickConfig MakeTickConfig(const base::DeviceGeometry& device) {
  return MakeTickConfig(device, tracker::MakeConfig(device), actuation::MakeConfig(device));
}

// The same for a base that has been calibrated.
inline TickConfig MakeTickConfig(const base::DeviceGeometry& device, const base::Calibration& calibration) {
  return MakeTickConfig(device, tracker::MakeConfig(calibration), actuation::MakeConfig(device, calibration));
}

}  // namespace omni::loop
