#include "service/magnetics/nominal.h"

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::magnetics {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

double MomentOf(const base::MagnetGeometry& magnet) noexcept { return MakeDiscMagnet(magnet).moment_Am2; }

void AddWindings(const std::vector<base::CoilGeometry>& coils, base::Calibration& array) {
  for (std::size_t k = 0; k < coils.size(); ++k) {
    const auto winding = MakeWinding(coils[k], static_cast<int>(k));
    const CoilMoments core = CoreMoments(winding, array.core_radius_m, array.core_kappa);
    const Eigen::Vector3d axis = base::ToEigen(coils[k].axis_base).normalized();
    for (base::SensorCalibration& sensor : array.sensors) {
      const Eigen::Map<const RowMajor3d> gain(sensor.gain_sensor_base.data());
      Eigen::Map<RowMajor3d> map(sensor.current_map_T_A.data());
      map.col(static_cast<int>(k)) = gain * CoilField(winding, core, axis, base::ToEigen(sensor.position_base_m));
    }
  }
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Columns: every coil's field per ampere at x, frame B.
Matrix3d CoilFields(const base::DeviceGeometry& device, const Vector3d& x) {
  Matrix3d B;
  for (int k = 0; k < static_cast<int>(base::kCoilCount); ++k) {
    const base::CoilGeometry& coil = device.coils[static_cast<std::size_t>(k)];
    const auto winding = MakeWinding(coil, k);
    const auto core = CoreMoments(winding, device.core_radius_m, device.core_kappa);
    B.col(k) = CoilField(winding, core, base::ToEigen(coil.axis_base).normalized(), x);
  }
  return B;
}

}  // namespace

base::Calibration NominalCalibration(const base::DeviceGeometry& device) {
  base::Calibration nominal;
  nominal.device = device.name;
  for (const base::SensorGeometry& drawn : device.sensors) {
    base::SensorCalibration sensor;
    sensor.position_base_m = drawn.position_base_m;
    const Matrix3d R_SB = base::ToEigen(drawn.orientation_base_sensor).normalized().toRotationMatrix().transpose();
    Eigen::Map<RowMajor3d>(sensor.gain_sensor_base.data()) = R_SB;
    Eigen::Map<RowMajor3d>(sensor.current_map_T_A.data()) =
        R_SB * CoilFields(device, base::ToEigen(drawn.position_base_m));
    nominal.sensors.push_back(sensor);
  }
  nominal.sensor_noise_T = device.sensor_noise_T;
  nominal.sensor_range_T = device.sensor_range_T;
  nominal.magnet = device.magnet;
  nominal.moment_Am2 = MakeDiscMagnet(device.magnet).moment_Am2;
  nominal.core_radius_m = device.core_radius_m;
  nominal.core_kappa = device.core_kappa;
  nominal.hull_radius_m = device.hull_radius_m;
  return nominal;
}

}  // namespace omni::magnetics
