// The measurement model: what Hall sensors should read for a pose of the tool. Any array of base::kArraySensorsMin ..
// kArraySensorsMax sensors, with or without core and coils. Prepared once from a base::Calibration; read-only then.
// Its origin is the core's centre. Arrays are laid out sensor by sensor in the last index and hold no Eigen type.
// docs/theory/tracking.md
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/vec.h"
#include "service/tracker/kernel/kernel.h"

namespace omni::tracker {

// The places that a cold start searches, and the readings that the magnet would cause at each. Set-up only.
// docs/theory/tracking.md (6.2), (6.3)
struct ColdGrid {
  int places = 0;
  std::vector<base::Vec3> place_base_m;
  // Field per moment (T / A m^2): [group of kGridLanes places][reading 3 i + axis][moment axis in B][place].
  std::vector<float> field_sensor;
};

// Shells around the hull where there is one; else the calibration's volume, or the sensors' surroundings, cut into
// cells that are small against their distance from the nearest sensor.
ColdGrid MakeColdGrid(const base::Calibration& calibration);

inline constexpr int kSensors = base::kSensorCount;  // of the Omni base: what the real-time path takes
inline constexpr int kReadings = 3 * kSensors;       // reading 3 i + axis
inline constexpr int kArraySensors = base::kArraySensorsMax;

using SensorLanes = std::array<double, kArraySensors>;

// How much of the physics the model includes; errors in docs/theory/tracking.md.
enum class Rung : std::uint8_t {
  kDipole,      // point dipole, no core
  kDipoleCore,  // point dipole and its image in the core
  kFull         // octupole and l = 5 of the magnet and of its image
};

// A steel plane under the base of an Omni: the images in it of its sensors and of the core's centre, the latter in
// every lane. docs/theory/tracking.md (12.1)
struct SteelMirror {
  double strength = 0;  // 0: none
  SensorPlaces<double> sensors{}, centre{};
};

// Prior covariance K of the non-uniform field of objects near the base of an Omni; readings 8 axis + sensor.
// docs/theory/tracking.md (13.1)
struct StrayPrior {
  std::array<double, std::size_t{kReadings} * kReadings> covariance_T2{};
};

// Prepared once from a Calibration.
struct Model {
  int sensors = 0;
  // Lanes beyond `sensors` repeat the last sensor and are never weighed.
  std::array<SensorPlaces<double>, kArraySensors / kBlockSensors> places{};
  std::array<SensorPlaces<float>, kArraySensors / kBlockSensors> places_float{};
  std::array<SensorLanes, 9> gain_sensor_base{};  // row-major, R_SB with gain and misalignment
  std::array<SensorLanes, 3> background_sensor_T{};
  std::array<double, std::size_t{3} * kArraySensors * base::kCoilCount> coil_map_T_A{};  // row 3 i + axis, column coil
  std::array<double, 3> noise_T{};                                                       // rms per sensor axis
  ToolSource<double> tool{};
  ToolSource<float> tool_float{};
  double moment_Am2 = 0;
  double magnet_radius_m = 0;
  double magnet_half_height_m = 0;
  double hull_radius_m = 0;
  std::array<double, 3> core_centre_base_m{};  // from here poses of the model and of its fits are measured
  double tip_offset_m = 0;
  double field_max_T = 0;                    // of the tool; a larger value is not a reading
  std::array<double, 9> core_current_A_T{};  // row-major, magnetics::CoreCurrents
  double expected_error_m = 0;               // rms of the position, that the calibration leaves; 0: unknown
  SteelMirror steel;
  StrayPrior stray;
  ColdGrid grid;
};

// Precondition: base::kArraySensorsMin .. kArraySensorsMax sensors, sizes of magnet and volume positive. Allocates.
Model MakeModel(const base::Calibration& calibration, Rung rung = Rung::kFull);

}  // namespace omni::tracker
