// A plausible calibration of a base of the nominal device, and that base.
#pragma once

#include "service/config/files/calibration_file.h"
#include "service/magnetics/nominal.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::support {

inline config::ExpectedBase NominalBase(const std::string& serial = "twin-3") {
  const base::DeviceGeometry device = NominalDevice();
  return {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = serial};
}

inline config::CalibrationFile ExampleCalibration() {
  config::CalibrationFile file;
  file.serial = "twin-3";
  file.date = "2026-11-21T09:00:00Z";
  file.quality = {.expected_error_mm = 0.08,
                  .frame_rotation_deg = 0.05,
                  .chi2_per_dof = 1.01,
                  .coverage = 0.95,
                  .samples = 500,
                  .touches = 100,
                  .unfixed = 2};
  file.calibration = NominalBase().drawing;
  file.calibration.moment_Am2 *= 1.0123456789012345;
  file.calibration.core_kappa = 0.9765625;
  file.calibration.core_kept_A = 0.01171875;
  file.calibration.hull_radius_m += 1e-3 / 3;
  file.calibration.core_centre_base_m = {1e-4, -1e-3 / 7, 2e-4};
  file.calibration.steel = {1.0 / 3, -0.2};
  for (std::size_t i = 0; i < file.calibration.sensors.size(); ++i) {
    base::SensorCalibration& sensor = file.calibration.sensors[i];
    sensor.position_base_m.x += 1e-3 / 3 * static_cast<double>(i);
    for (std::size_t e = 0; e < 9; ++e) {
      sensor.gain_sensor_base[e] += 0.01 / (1.0 + static_cast<double>(e + i));
      sensor.current_map_T_A[e] *= 1.01;
    }
    sensor.background_sensor_T = {2e-5, -1.1e-5, 4.3e-5};
  }
  return file;
}

}  // namespace omni::support
