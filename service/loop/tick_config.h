// TickConfig from a device's geometry: everything the tick reads is prepared here, off the tick.
#pragma once

#include "service/base/calibration.h"
#include "service/base/device_geometry.h"
#include "service/loop/tick.h"

namespace omni::loop {

inline TickConfig MakeTickConfig(const base::DeviceGeometry& device) {
  TickConfig config;
  config.tracker = tracker::MakeConfig(device);
  config.actuation = actuation::MakeConfig(device);
  config.tip_offset_m = device.magnet.tip_offset_m;
  return config;
}

// The same for a base that has been calibrated.
inline TickConfig MakeTickConfig(const base::DeviceGeometry& device, const base::Calibration& calibration) {
  TickConfig config = MakeTickConfig(device);
  config.tracker = tracker::MakeConfig(calibration);
  config.actuation = actuation::MakeConfig(device, calibration);
  return config;
}

}  // namespace omni::loop
