#include "service/tracker/kernel/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "service/base/eigen.h"
#include "service/magnetics/dipole.h"

namespace omni::tracker {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kSurroundings_m = 0.15;  // beyond the sensors, where no volume is given
constexpr std::size_t kPlacesMax = 4000;
constexpr double kCellFloor_m = 4e-3;

// Shells between contact and the far end of the haptic reach, 12 directions on a Fibonacci spiral over the upper
// hemisphere and a little below. docs/theory/tracking.md (6.3)
std::vector<Vector3d> AroundHull() {
  constexpr int kDirections = 12;
  constexpr double kRadii_m[] = {0.050, 0.082, 0.135};
  std::vector<Vector3d> places;
  for (std::size_t shell = 0; shell < std::size(kRadii_m); ++shell) {
    for (int i = 0; i < kDirections; ++i) {
      const double z = -0.15 + 1.15 * (i + 0.5) / kDirections;
      const double phi = i * std::numbers::pi * (3 - std::sqrt(5.0)) + static_cast<double>(shell);
      const double rho = std::sqrt(1 - z * z);
      places.emplace_back(kRadii_m[shell] * Vector3d(rho * std::cos(phi), rho * std::sin(phi), z));
    }
  }
  return places;
}

struct Box {
  Vector3d low, high;
};

Box VolumeOf(const base::Calibration& calibration) {
  Box given{base::ToEigen(calibration.volume_min_base_m), base::ToEigen(calibration.volume_max_base_m)};
  if ((given.high - given.low).minCoeff() > 0) return given;
  constexpr double kHuge = std::numeric_limits<double>::max();
  Box around{Vector3d::Constant(kHuge), Vector3d::Constant(-kHuge)};
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    around.low = around.low.cwiseMin(base::ToEigen(sensor.position_base_m));
    around.high = around.high.cwiseMax(base::ToEigen(sensor.position_base_m));
  }
  return {around.low.array() - kSurroundings_m, around.high.array() + kSurroundings_m};
}

double NearestSensor_m(const base::Calibration& calibration, const Vector3d& x) {
  double nearest = std::numeric_limits<double>::max();
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    nearest = std::min(nearest, (base::ToEigen(sensor.position_base_m) - x).norm());
  }
  return nearest;
}

// Halves a box along its longest side until its half diagonal is `ratio` of the distance to the nearest sensor; a
// centre where the magnet would touch a sensor is no place.
void Subdivide(const base::Calibration& calibration, const Box& box, double ratio, double clear_m,
               std::vector<Vector3d>& places) {
  if (places.size() > kPlacesMax) return;
  const Vector3d centre = 0.5 * (box.low + box.high);
  const Vector3d size = box.high - box.low;
  const double distance_m = NearestSensor_m(calibration, centre);
  if (0.5 * size.norm() <= std::max(ratio * distance_m, kCellFloor_m)) {
    if (distance_m >= clear_m) places.push_back(centre);
    return;
  }
  int longest = 0;
  size.maxCoeff(&longest);
  Box lower = box, upper = box;
  lower.high[longest] = upper.low[longest] = centre[longest];
  Subdivide(calibration, lower, ratio, clear_m, places);
  Subdivide(calibration, upper, ratio, clear_m, places);
}

std::vector<Vector3d> InVolume(const base::Calibration& calibration) {
  const Box volume = VolumeOf(calibration);
  const double clear_m = 0.5 * std::min(calibration.magnet.radius_m, 2 * calibration.magnet.half_height_m);
  std::vector<Vector3d> places;
  for (double ratio = 0.35; places.empty() || places.size() > kPlacesMax; ratio *= 1.25) {
    places.clear();
    Subdivide(calibration, volume, ratio, clear_m, places);
    if (places.empty()) places.emplace_back(0.5 * (volume.low + volume.high));
  }
  return places;
}

// Dipole at p plus the core's uniform response a^3 kappa D(p) m 1e7 at the origin.
Matrix3d LeadField(const base::Calibration& calibration, const base::SensorCalibration& sensor, const Vector3d& p) {
  const Vector3d s = base::ToEigen(sensor.position_base_m);
  Matrix3d field = magnetics::DipoleMatrix(s - p);
  if (calibration.core_radius_m > 0) {
    const double a3 = std::pow(calibration.core_radius_m, 3) * calibration.core_kappa / magnetics::kMu0Over4Pi;
    field += a3 * magnetics::DipoleMatrix(s) * magnetics::DipoleMatrix(p);
  }
  return Eigen::Map<const RowMajor3>(sensor.gain_sensor_base.data()) * field;
}

}  // namespace

ColdGrid MakeColdGrid(const base::Calibration& calibration) {
  const std::vector<Vector3d> places = calibration.hull_radius_m > 0 ? AroundHull() : InVolume(calibration);
  ColdGrid grid;
  grid.places = static_cast<int>(places.size());
  const std::size_t groups = (places.size() + kGridLanes - 1) / kGridLanes;
  const std::size_t readings = 3 * calibration.sensors.size();
  grid.field_sensor.resize(groups * readings * 3 * kGridLanes);
  for (std::size_t lane = 0; lane < groups * kGridLanes; ++lane) {
    const Vector3d& p = places[std::min(lane, places.size() - 1)];  // the last group is filled up with the last place
    if (lane < places.size()) grid.place_base_m.push_back(base::FromEigen(p));
    for (std::size_t i = 0; i < calibration.sensors.size(); ++i) {
      const Matrix3d G = LeadField(calibration, calibration.sensors[i], p);
      for (std::size_t e = 0; e < 9; ++e) {
        const std::size_t reading = 3 * i + e / 3;
        grid.field_sensor[((lane / kGridLanes * readings + reading) * 3 + e % 3) * kGridLanes + lane % kGridLanes] =
            static_cast<float>(G(static_cast<int>(e) / 3, static_cast<int>(e) % 3));
      }
    }
  }
  return grid;
}

}  // namespace omni::tracker
