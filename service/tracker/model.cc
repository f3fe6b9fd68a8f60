#include "service/tracker/model.h"

#include <cmath>
#include <numbers>

#include "service/base/eigen.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::tracker {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void PlaceSensors(const base::Calibration& calibration, Model& model) {
  for (std::size_t i = 0; i < kSensors; ++i) {
    const base::SensorCalibration& sensor = calibration.sensors[i];
    const Vector3d s = base::ToEigen(sensor.position_base_m);
    const Vector3d shape = s / (s.squaredNorm() * s.norm());
    const base::Vec3& background = sensor.background_sensor_T;
    model.background_sensor_T[0][i] = background.x;
    model.background_sensor_T[1][i] = background.y;
    model.background_sensor_T[2][i] = background.z;
    for (std::size_t row = 0; row < 3; ++row) {
      model.sensor_position_base_m[row][i] = s[static_cast<int>(row)];
      model.sensor_over_r3_base[row][i] = shape[static_cast<int>(row)];
      for (std::size_t column = 0; column < 3; ++column) {
        model.gain_sensor_base[3 * row + column][i] = sensor.gain_sensor_base[3 * row + column];
        model.coil_map_T_A[(3 * i + row) * base::kCoilCount + column] = sensor.current_map_T_A[3 * row + column];
      }
    }
  }
}

Matrix3d GainSensorBase(const Model& model, std::size_t i) {
  Matrix3d G;
  for (std::size_t e = 0; e < 9; ++e) {
    G(static_cast<int>(e) / 3, static_cast<int>(e) % 3) = model.gain_sensor_base[e][i];
  }
  return G;
}

// Where the cold start looks: shells between contact and the far end of the haptic reach, 12 directions on a Fibonacci
// spiral over the upper hemisphere and a little below. docs/theory/tracking.md (9)
base::Vec3 GridPoint(int index) {
  constexpr int kDirections = 12;
  constexpr double kRadii_m[] = {0.050, 0.082, 0.135};
  static_assert(kDirections * std::size(kRadii_m) == kGridPoints);
  const int shell = index / kDirections;
  const int i = index % kDirections;
  const double z = -0.15 + 1.15 * (i + 0.5) / kDirections;
  const double phi = i * std::numbers::pi * (3 - std::sqrt(5.0)) + shell;
  const double r = kRadii_m[shell];
  const double rho = std::sqrt(1 - z * z);
  return {r * rho * std::cos(phi), r * rho * std::sin(phi), r * z};
}

// G_p: dipole at p plus the core's uniform answer a^3 kappa D(p) m 1e7 at the origin.
void PrepareGrid(Model& model) {
  const double a3 = std::pow(model.core_radius_m, 3) * model.core_kappa / magnetics::kMu0Over4Pi;
  for (std::size_t g = 0; g < kGridPoints; ++g) {
    model.grid_base_m[g] = GridPoint(static_cast<int>(g));
    const Vector3d p = base::ToEigen(model.grid_base_m[g]);
    for (std::size_t i = 0; i < kSensors; ++i) {
      const Vector3d s(model.sensor_position_base_m[0][i], model.sensor_position_base_m[1][i],
                       model.sensor_position_base_m[2][i]);
      const Matrix3d G = GainSensorBase(model, i) * (magnetics::DipoleMatrix(s - p) +
                                                     a3 * magnetics::DipoleMatrix(s) * magnetics::DipoleMatrix(p));
      for (std::size_t e = 0; e < 9; ++e) {
        model.grid_field_sensor[g][9 * i + e] = G(static_cast<int>(e) / 3, static_cast<int>(e) % 3);
      }
    }
  }
}

}  // namespace

Model MakeModel(const base::Calibration& calibration) {
  Model model;
  const magnetics::DiscMagnet magnet = magnetics::MakeDiscMagnet(calibration.magnet, calibration.moment_Am2);
  model.tool_zonal = magnet.zonal;
  for (std::size_t s = 0; s < model.tool_points.size(); ++s) {
    const magnetics::MagnetPoint& point = magnet.points[s];
    model.tool_points[s] = {point.ring_1_m, point.ring_2_m, point.axial_m, point.share * magnet.moment_Am2};
  }
  model.noise_T = calibration.sensor_noise_T;
  model.core_radius_m = calibration.core_radius_m;
  model.core_kappa = calibration.core_kappa;
  model.magnet_radius_m = calibration.magnet.radius_m;
  model.magnet_half_height_m = calibration.magnet.half_height_m;
  model.hull_radius_m = calibration.hull_radius_m;
  model.tip_offset_m = calibration.magnet.tip_offset_m;
  PlaceSensors(calibration, model);
  PrepareGrid(model);
  return model;
}

}  // namespace omni::tracker
