// A base and its tool, nominal (as read from manifests/device/*.toml) and calibrated. Frame B, SI.
// Both the tracker's models and the digital twin start from the nominal one; the twin then adds its own imperfections.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::base {

struct SensorGeometry {
  Vec3 position_base_m;
  Quat orientation_base_sensor;  // R_BS
};

// A coil as a band of circular turns about `axis`, wound from inner to outer radius.
// Turns lie on `layers` spherical shells interleaved between the three axes.
struct CoilGeometry {
  Vec3 axis_base{0, 0, 1};
  int turns = 0;
  int layers = 0;
  double shell_radius_min_m = 0;
  double shell_radius_max_m = 0;
  double band_half_width_m = 0;
  double resistance_20C_ohm = 0;
  double inductance_H = 0;
};

enum class MagnetShape : std::uint8_t { kCylinder, kSphere };

// Magnetised along its axis.
struct MagnetGeometry {
  MagnetShape shape = MagnetShape::kCylinder;
  double radius_m = 0;
  double half_height_m = 0;  // of a cylinder; a sphere's is its radius
  double remanence_T = 0;
  double mass_kg = 0;       // of the whole tool
  double tip_offset_m = 0;  // device point = magnet centre + tip_offset_m * axis
};

// Thermal model of the base: every coil's copper C_c, cooled by a body (core, plastic, table) C_b that all coils share,
// cooled by the air. Defaults: copper from the mass of its wire, the rest from the paper's three temperatures of one
// coil (docs/theory/thermal.md).
struct HeatGeometry {
  double copper_J_K = 44.4;
  double body_J_K = 94.2;
  double copper_to_body_W_K = 1.048;
  double body_to_air_W_K = 0.7903;
  double air_C = 24;
};

struct DeviceGeometry {
  std::string name;
  std::array<SensorGeometry, kSensorCount> sensors;
  std::array<CoilGeometry, kCoilCount> coils;
  MagnetGeometry magnet;
  double core_radius_m = 0;
  double core_kappa = 1;  // (mu_r - 1) / (mu_r + 2)
  double hull_radius_m = 0;
  double sensor_range_T = 0;  // full scale
  double sensor_lsb_T = 0;
  std::array<double, 3> sensor_noise_T{};  // rms per axis at 1 kHz
  double current_max_A = 0;
  double current_slew_A_s = 0;
  double force_max_N = 0;
  double temperature_max_C = 0;     // currents are derated to zero here
  double temperature_derate_C = 0;  // derating starts here
  double supply_V = 0;
  HeatGeometry heat;
};

// Parameters of one particular sensor array and its magnet: all that the tracker's model needs.
// magnetics::NominalCalibration derives it from the nominal geometry, self-calibration measures it, a device file may
// describe any other array. Frame B, SI. Set-up only.
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
