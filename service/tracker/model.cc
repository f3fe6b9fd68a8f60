#include "service/tracker/model.h"

#include <cmath>
#include <numbers>

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::tracker {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void PlaceSensors(const base::DeviceGeometry& device, Model& model) {
  for (std::size_t i = 0; i < kSensors; ++i) {
    const Vector3d s = base::ToEigen(device.sensors[i].position_base_m);
    const Matrix3d R_SB =
        base::ToEigen(device.sensors[i].orientation_base_sensor).normalized().toRotationMatrix().transpose();
    const Vector3d shape = s / (s.squaredNorm() * s.norm());
    for (int row = 0; row < 3; ++row) {
      model.sensor_position_base_m[static_cast<std::size_t>(row)][i] = s[row];
      model.sensor_over_r3_base[static_cast<std::size_t>(row)][i] = shape[row];
      for (int column = 0; column < 3; ++column) {
        model.rotation_sensor_base[3 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column)][i] =
            R_SB(row, column);
      }
    }
  }
}

Matrix3d RotationSensorBase(const Model& model, std::size_t i) {
  Matrix3d R_SB;
  for (std::size_t e = 0; e < 9; ++e) {
    R_SB(static_cast<int>(e) / 3, static_cast<int>(e) % 3) = model.rotation_sensor_base[e][i];
  }
  return R_SB;
}

// A in y = B_tool + A I: every coil's field per ampere at every sensor axis, core included.
void MapCoils(const base::DeviceGeometry& device, Model& model) {
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const auto winding = magnetics::MakeWinding(device.coils[k], static_cast<int>(k));
    const auto core = magnetics::CoreMoments(winding, device.core_radius_m, device.core_kappa);
    const Vector3d axis = base::ToEigen(device.coils[k].axis_base).normalized();
    for (std::size_t i = 0; i < kSensors; ++i) {
      const Vector3d B_S = RotationSensorBase(model, i) *
                           magnetics::CoilField(winding, core, axis, base::ToEigen(device.sensors[i].position_base_m));
      for (std::size_t row = 0; row < 3; ++row) {
        model.coil_map_T_A[(3 * i + row) * base::kCoilCount + k] = B_S[static_cast<int>(row)];
      }
    }
  }
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
      const Matrix3d G = RotationSensorBase(model, i) * (magnetics::DipoleMatrix(s - p) +
                                                         a3 * magnetics::DipoleMatrix(s) * magnetics::DipoleMatrix(p));
      for (std::size_t e = 0; e < 9; ++e) {
        model.grid_field_sensor[g][9 * i + e] = G(static_cast<int>(e) / 3, static_cast<int>(e) % 3);
      }
    }
  }
}

}  // namespace

Model MakeModel(const base::DeviceGeometry& device) {
  Model model;
  const magnetics::DiscMagnet magnet = magnetics::MakeDiscMagnet(device.magnet);
  model.tool_zonal = magnet.zonal;
  for (std::size_t s = 0; s < model.tool_points.size(); ++s) {
    const magnetics::MagnetPoint& point = magnet.points[s];
    model.tool_points[s] = {point.ring_1_m, point.ring_2_m, point.axial_m, point.share * magnet.moment_Am2};
  }
  model.noise_T = device.sensor_noise_T;
  model.core_radius_m = device.core_radius_m;
  model.core_kappa = device.core_kappa;
  model.magnet_radius_m = device.magnet.radius_m;
  model.magnet_half_height_m = device.magnet.half_height_m;
  model.hull_radius_m = device.hull_radius_m;
  model.tip_offset_m = device.magnet.tip_offset_m;
  PlaceSensors(device, model);
  MapCoils(device, model);
  PrepareGrid(model);
  return model;
}

}  // namespace omni::tracker
