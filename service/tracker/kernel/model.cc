#include "service/tracker/kernel/model.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"
#include "service/tracker/solve/spiral.h"

namespace omni::tracker {
namespace {

constexpr double kRanges = 4;        // of a sensor: the coils' field has been subtracted from its reading
constexpr double kFieldMax_T = 1e3;  // of sensors whose range is not known

using Eigen::Vector3d;

// s' = (a/r)^2 s, n = s/r, kappa (a/r)^3, kappa a/r^2. docs/theory/tracking.md (2.1)
void PlaceSensor(const base::Calibration& calibration, const Vector3d& s, std::size_t lane,
                 SensorPlaces<double>& places) {
  const double r = s.norm();
  const double ratio = r > 0 ? calibration.core_radius_m / r : 0.0;  // at the origin only where there is no core
  for (std::size_t row = 0; row < 3; ++row) {
    places.position_base_m[row][lane] = s[static_cast<int>(row)];
    places.image_base_m[row][lane] = ratio * ratio * s[static_cast<int>(row)];
    places.radial_base[row][lane] = r > 0 ? s[static_cast<int>(row)] / r : 0.0;
  }
  places.image_field_gain[lane] = calibration.core_kappa * ratio * ratio * ratio;
  places.image_potential_gain_1_m[lane] = r > 0 ? calibration.core_kappa * ratio / r : 0.0;
}

// s' = M s + (0, 0, 2 height), M = diag(1, 1, -1). `calibration`: from the core's centre.
SteelMirror MirrorSensors(const base::Calibration& calibration) {
  SteelMirror mirror;
  mirror.strength = calibration.sensors.size() == kSensors ? calibration.steel.strength : 0.0;
  if (mirror.strength == 0) return mirror;
  const Vector3d centre(0, 0, 2 * calibration.steel.height_base_m);
  for (std::size_t i = 0; i < kSensors; ++i) {
    const base::Vec3& s = calibration.sensors[i].position_base_m;
    PlaceSensor(calibration, centre + Vector3d(s.x, s.y, -s.z), i, mirror.sensors);
    PlaceSensor(calibration, centre, i, mirror.centre);
  }
  return mirror;
}

using ReadingVector = Eigen::Matrix<double, kReadings, 1>;

// A dipole's field in the readings, without the part common to all sensors.
ReadingVector UnevenReadings(const base::Calibration& calibration, const Vector3d& at_m, const Vector3d& moment_Am2) {
  Eigen::Matrix<double, 3, kSensors> field_T;
  for (std::size_t i = 0; i < kSensors; ++i) {
    field_T.col(static_cast<int>(i)) =
        magnetics::DipoleField(moment_Am2, base::ToEigen(calibration.sensors[i].position_base_m) - at_m);
  }
  const Vector3d mean_T = field_T.rowwise().mean();
  field_T.colwise() -= mean_T;
  ReadingVector readings_T;
  for (std::size_t i = 0; i < kSensors; ++i) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> gain(
        calibration.sensors[i].gain_sensor_base.data());
    const Vector3d sensor_T = gain * field_T.col(static_cast<int>(i));
    for (int axis = 0; axis < 3; ++axis) readings_T[kSensors * axis + static_cast<int>(i)] = sensor_T[axis];
  }
  return readings_T;
}

// Dipoles as strong as the pen all around at two distances, plus a small isotropic part:   K = mean b b^T + sigma^2
StrayPrior MakeStrayPrior(const base::Calibration& calibration) {
  constexpr int kDirections = 64;
  constexpr std::array<double, 2> kDistances_m{0.2, 0.3};
  constexpr double kAnything_T = 2e-6;
  StrayPrior prior;
  if (calibration.sensors.size() != kSensors) return prior;
  Eigen::Map<Eigen::Matrix<double, kReadings, kReadings>> K(prior.covariance_T2.data());
  for (const double distance_m : kDistances_m) {
    for (int n = 0; n < kDirections; ++n) {
      const Vector3d at_m = distance_m * OnSpiral(n, kDirections);
      for (int axis = 0; axis < 3; ++axis) {
        const ReadingVector b = UnevenReadings(calibration, at_m, calibration.moment_Am2 * Vector3d::Unit(axis));
        K += b * b.transpose() / (kDirections * kDistances_m.size());
      }
    }
  }
  K.diagonal().array() += kAnything_T * kAnything_T;
  return prior;
}

template <std::size_t kRows>
void Narrow(const double (&from)[kRows][kBlockSensors], float (&to)[kRows][kBlockSensors]) {
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t i = 0; i < kBlockSensors; ++i) to[row][i] = static_cast<float>(from[row][i]);
  }
}

SensorPlaces<float> Narrow(const SensorPlaces<double>& places) {
  SensorPlaces<float> narrow{};
  Narrow(places.position_base_m, narrow.position_base_m);
  Narrow(places.image_base_m, narrow.image_base_m);
  Narrow(places.radial_base, narrow.radial_base);
  for (std::size_t i = 0; i < kBlockSensors; ++i) {
    narrow.image_field_gain[i] = static_cast<float>(places.image_field_gain[i]);
    narrow.image_potential_gain_1_m[i] = static_cast<float>(places.image_potential_gain_1_m[i]);
  }
  return narrow;
}

void PlaceSensors(const base::Calibration& calibration, Model& model) {
  model.sensors = static_cast<int>(calibration.sensors.size());
  for (std::size_t i = 0; i < kArraySensors; ++i) {
    const base::SensorCalibration& sensor = calibration.sensors[std::min(i, calibration.sensors.size() - 1)];
    PlaceSensor(calibration, base::ToEigen(sensor.position_base_m), i % kBlockSensors, model.places[i / kBlockSensors]);
    const base::Vec3& background = sensor.background_sensor_T;
    model.background_sensor_T[0][i] = background.x;
    model.background_sensor_T[1][i] = background.y;
    model.background_sensor_T[2][i] = background.z;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        model.gain_sensor_base[3 * row + column][i] = sensor.gain_sensor_base[3 * row + column];
        model.coil_map_T_A[(3 * i + row) * base::kCoilCount + column] = sensor.current_map_T_A[3 * row + column];
      }
    }
  }
  std::transform(model.places.begin(), model.places.end(), model.places_float.begin(),
                 [](const SensorPlaces<double>& places) { return Narrow(places); });
}

ToolSource<double> MakeTool(const base::Calibration& calibration, Rung rung) {
  const magnetics::DiscMagnet magnet = magnetics::MakeDiscMagnet(calibration.magnet, calibration.moment_Am2);
  ToolSource<double> tool{};
  std::copy(magnet.zonal.begin(), magnet.zonal.end(), tool.zonal);
  if (rung != Rung::kFull) tool.zonal[1] = tool.zonal[2] = 0;
  tool.multipole = tool.zonal[1] != 0 || tool.zonal[2] != 0;
  tool.core = rung != Rung::kDipole && calibration.core_radius_m > 0;
  return tool;
}

ToolSource<float> Narrow(const ToolSource<double>& tool) {
  ToolSource<float> narrow{};
  std::transform(std::begin(tool.zonal), std::end(tool.zonal), std::begin(narrow.zonal),
                 [](double q) { return static_cast<float>(q); });
  narrow.multipole = tool.multipole;
  narrow.core = tool.core;
  return narrow;
}

// The same with everything measured from the core's centre.
base::Calibration FromCore(base::Calibration calibration) {
  const base::Vec3& c = calibration.core_centre_base_m;
  const auto move = [&](base::Vec3& at) { at = {at.x - c.x, at.y - c.y, at.z - c.z}; };
  for (base::SensorCalibration& sensor : calibration.sensors) move(sensor.position_base_m);
  calibration.steel.height_base_m -= c.z;
  move(calibration.volume_min_base_m);
  move(calibration.volume_max_base_m);
  return calibration;
}

}  // namespace

Model MakeModel(const base::Calibration& in_base, Rung rung) {
  const base::Calibration calibration = FromCore(in_base);
  Model model;
  const base::Vec3& centre = in_base.core_centre_base_m;
  model.core_centre_base_m = {centre.x, centre.y, centre.z};
  PlaceSensors(calibration, model);
  model.tool = MakeTool(calibration, rung);
  model.tool_float = Narrow(model.tool);
  model.moment_Am2 = calibration.moment_Am2;
  model.noise_T = calibration.sensor_noise_T;
  model.magnet_radius_m = calibration.magnet.radius_m;
  model.magnet_half_height_m = calibration.magnet.shape == base::MagnetShape::kSphere
                                   ? calibration.magnet.radius_m
                                   : calibration.magnet.half_height_m;
  model.hull_radius_m = calibration.hull_radius_m;
  model.tip_offset_m = calibration.magnet.tip_offset_m;
  model.field_max_T = calibration.sensor_range_T > 0 ? kRanges * calibration.sensor_range_T : kFieldMax_T;
  model.expected_error_m = calibration.expected_error_m;
  using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Map<RowMajor3d>(model.core_current_A_T.data()) = magnetics::CoreCurrents(calibration);
  model.steel = MirrorSensors(calibration);
  model.stray = MakeStrayPrior(calibration);
  model.grid = MakeColdGrid(calibration);
  return model;
}

}  // namespace omni::tracker
