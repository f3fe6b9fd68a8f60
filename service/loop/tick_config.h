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
