#include "service/magnetics/core_currents.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/dipole.h"

namespace omni::magnetics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kMomentMin_Am2 = 1e-3;  // per ampere, of the weakest direction: less is no coil

// (sum D^T D) P = sum D^T A, D = mu0/4pi G (3 n n^T - I) / s^3
Matrix3d CoilMomentsFromMaps(const base::Calibration& calibration) {
  Matrix3d square = Matrix3d::Zero(), along = Matrix3d::Zero();
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    const Vector3d s = base::ToEigen(sensor.position_base_m), n = s.normalized();
    const Matrix3d dipole = kMu0Over4Pi / std::pow(s.norm(), 3) * (3 * n * n.transpose() - Matrix3d::Identity());
    const Matrix3d unit = Eigen::Map<const RowMajor3d>(sensor.gain_sensor_base.data()) * dipole;
    square += unit.transpose() * unit;
    along += unit.transpose() * Eigen::Map<const RowMajor3d>(sensor.current_map_T_A.data());
  }
  return square.ldlt().solve(along);
}

}  // namespace

Matrix3d CoreCurrents(const base::Calibration& calibration) {
  const double core_Am5 = std::pow(calibration.core_radius_m, 3) * calibration.core_kappa * calibration.moment_Am2;
  if (!(core_Am5 > 0)) return Matrix3d::Zero();
  const Matrix3d moments = CoilMomentsFromMaps(calibration);
  const bool three = moments.allFinite() && std::abs(moments.determinant()) > std::pow(kMomentMin_Am2, 3);
  return three ? Matrix3d(core_Am5 * moments.inverse()) : Matrix3d(Matrix3d::Zero());
}

Vector3d CoreFieldShape(const Vector3d& p_m, const Vector3d& u) noexcept {
  const double r_m = p_m.norm();
  if (!(r_m > 0)) return Vector3d::Zero();
  const Vector3d n = p_m / r_m;
  return (3 * n.dot(u) * n - u) / (r_m * r_m * r_m);
}

}  // namespace omni::magnetics
