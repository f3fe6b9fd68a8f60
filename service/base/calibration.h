// Parameters of one particular sensor array and its magnet: all that the tracker's model needs.
// magnetics::NominalCalibration derives it from the nominal geometry, self-calibration measures it, a device file may
// describe any other array. Frame B, SI. Set-up only.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::base {

inline constexpr int kArraySensorsMin = 4;
inline constexpr int kArraySensorsMax = 64;
inline constexpr double kCoreKeptMin_A = 1e-3, kCoreKeptMax_A = 0.1;  // the range that a calibration searches

// reading_S = gain_sensor_base B(position) + current_map I + background
struct SensorCalibration {
  Vec3 position_base_m;
  std::array<double, 9> gain_sensor_base{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major: R_SB with gains and misalignment
  std::array<double, 9> current_map_T_A{};                            // row-major: axis of S by coil; core included
  Vec3 background_sensor_T;
};

// Acts like a magnetic mirror below the base: a steel desk. docs/theory/tracking.md (12.1)
struct SteelPlane {
  double strength = 0;       // 0: none; 1: of much iron
  double height_base_m = 0;  // z of the plane, < 0
};

struct Calibration {
  std::string device;                      // name of the device it belongs to
  std::vector<SensorCalibration> sensors;  // kArraySensorsMin .. kArraySensorsMax
  std::array<double, 3> sensor_noise_T{};  // rms per axis of S
  double sensor_range_T = 0;               // full scale; 0: unknown
  MagnetGeometry magnet;                   // shape and size; remanence_T does not define the moment here:
  double moment_Am2 = 0;                   // > 0
  double core_radius_m = 0;                // 0: no core
  double core_kappa = 1;                   // (mu_r - 1) / (mu_r + 2)
  double core_kept_A = 0;                  // of any motion, as a current (hysteresis); 0: unknown
  Vec3 core_centre_base_m;                 // frame B is that of hull and windings
  double hull_radius_m = 0;                // 0: no hull
  SteelPlane steel;
  double expected_error_m = 0;  // rms position error that the calibration says it leaves; 0: unknown
  // Where the magnet may be; equal corners: derived from hull or sensors.
  Vec3 volume_min_base_m, volume_max_base_m;
};

}  // namespace omni::base
