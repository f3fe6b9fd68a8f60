// The nominal device of manifests/device/omni.toml written out by hand, for tests of modules that do not read files.
#pragma once

#include <cmath>
#include <numbers>

#include "service/base/device_geometry.h"

namespace omni::support {

inline base::DeviceGeometry NominalDevice() {
  base::DeviceGeometry device;
  device.name = "nominal";
  for (int i = 0; i < base::kSensorCount; ++i) {
    const bool lower = i >= 4;
    const double angle = (i % 4) * std::numbers::pi / 2 + (lower ? std::numbers::pi / 4 : 0.0);
    device.sensors[static_cast<std::size_t>(i)].position_base_m = {0.060 * std::cos(angle), 0.060 * std::sin(angle),
                                                                   lower ? -0.095 : -0.075};
  }
  const int turns[3] = {156, 158, 160};
  const double resistance[3] = {0.633, 0.666, 0.697};
  const double inductance_H[3] = {1.05e-3, 1.10e-3, 1.15e-3};
  for (std::size_t k = 0; k < device.coils.size(); ++k) {
    base::CoilGeometry& coil = device.coils[k];
    coil.axis_base = {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
    coil.turns = turns[k];
    coil.layers = 6;
    coil.shell_radius_min_m = 0.015;
    coil.shell_radius_max_m = 0.0325;
    coil.band_half_width_m = 0.0112;
    coil.resistance_20C_ohm = resistance[k];
    coil.inductance_H = inductance_H[k];
  }
  device.magnet = {
      .radius_m = 0.015, .half_height_m = 0.0035, .remanence_T = 1.3, .mass_kg = 0.038, .tip_offset_m = 0.005};
  device.core_radius_m = 0.015;
  device.core_kappa = 0.997;
  device.hull_radius_m = 0.0375;
  device.sensor_range_T = 1.6e-3;
  device.sensor_lsb_T = 1.0 / 17110000;
  device.sensor_noise_T = {8e-7, 8e-7, 1e-6};
  device.current_max_A = 15;
  device.current_slew_A_s = 5000;
  device.force_max_N = 2;
  device.temperature_derate_C = 60;
  device.temperature_max_C = 70;
  device.supply_V = 18;
  return device;
}

}  // namespace omni::support
