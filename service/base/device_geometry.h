// Nominal description of a base and its tool, as read from manifests/device/*.toml. Frame B, SI.
// Both the tracker's models and the digital twin start from it; the twin then adds its own imperfections.
#pragma once

#include <array>
#include <cstdint>
#include <string>

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

}  // namespace omni::base
