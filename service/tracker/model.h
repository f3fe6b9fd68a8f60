// The measurement model: what the eight Hall sensors should read for a pose of the tool, and what they did read.
// Arrays are laid out sensor by sensor in the last index (one lane per sensor) and hold no Eigen type, so that the hot
// kernel (linearise.cc) can be built for any vector width. docs/theory/tracking.md
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

#include "service/base/calibration.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::tracker {

inline constexpr int kSensors = base::kSensorCount;
inline constexpr int kReadings = 3 * kSensors;  // reading 3 i + axis
inline constexpr int kParameters = 5;           // position x, y, z (m); turn of the axis along e1, e2 (rad)
inline constexpr int kGridPoints = 36;          // cold start
inline constexpr int kImageSources = 5;         // magnetics::kMagnetPoints

using SensorLanes = std::array<double, kSensors>;

// Point dipole standing for part of the tool's moment, at ring_1 e1 + ring_2 e2 + axial u from its centre.
struct ToolPoint {
  double ring_1_m = 0;
  double ring_2_m = 0;
  double axial_m = 0;
  double moment_Am2 = 0;
};

// Prepared once from a Calibration.
struct Model {
  std::array<SensorLanes, 3> sensor_position_base_m{};
  std::array<SensorLanes, 3> sensor_over_r3_base{};  // s / |s|^3: field shape of a charge at the core's centre
  std::array<SensorLanes, 9> gain_sensor_base{};     // row-major, R_SB with gain and misalignment
  std::array<SensorLanes, 3> background_sensor_T{};
  std::array<double, std::size_t{kReadings} * base::kCoilCount> coil_map_T_A{};  // row 3 i + axis, column coil
  std::array<double, 3> noise_T{};                                               // rms per sensor axis
  std::array<double, 3> tool_zonal{};                                            // q1, q3, q5 of the tool, A m^(l+1)
  std::array<ToolPoint, kImageSources> tool_points{};
  double core_radius_m = 0;
  double core_kappa = 0;
  double magnet_radius_m = 0;
  double magnet_half_height_m = 0;
  double hull_radius_m = 0;
  double tip_offset_m = 0;
  // Cold start: positions to try and the field per moment (T / A m^2) there, row 3 i + axis, column moment axis in B.
  std::array<base::Vec3, kGridPoints> grid_base_m{};
  std::array<std::array<double, std::size_t{kReadings} * 3>, kGridPoints> grid_field_sensor{};
};
static_assert(std::is_trivially_copyable_v<Model>);

// Precondition: kSensors sensors.
Model MakeModel(const base::Calibration& calibration);

}  // namespace omni::tracker
