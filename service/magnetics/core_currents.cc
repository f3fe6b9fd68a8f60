#include "service/magnetics/core_currents.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/dipole.h"

namespace omni::magnetics {
namespace {

using Eigen::Matrix3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kMomentMin_Am2 = 1e-3;  // per ampere, of the weakest direction: less is no coil

// (sum D^T D) P = sum D^T A, D = G DipoleMatrix(s)
Matrix3d CoilMomentsFromMaps(const base::Calibration& calibration) {
  Matrix3d square = Matrix3d::Zero(), along = Matrix3d::Zero();
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    const Matrix3d unit = Eigen::Map<const RowMajor3d>(sensor.gain_sensor_base.data()) *
                          DipoleMatrix(base::ToEigen(sensor.position_base_m));
    square += unit.transpose() * unit;
    along += unit.transpose() * Eigen::Map<const RowMajor3d>(sensor.current_map_T_A.data());
  }
  return square.ldlt().solve(along);
}

}  // namespace

Matrix3d CoreCurrents(const base::Calibration& calibration) {
  const double core_Am2_T = std::pow(calibration.core_radius_m, 3) * calibration.core_kappa / kMu0Over4Pi;
  if (!(core_Am2_T > 0)) return Matrix3d::Zero();
  const Matrix3d moments = CoilMomentsFromMaps(calibration);
  const bool three = moments.allFinite() && std::abs(moments.determinant()) > std::pow(kMomentMin_Am2, 3);
  return three ? Matrix3d(core_Am2_T * moments.inverse()) : Matrix3d(Matrix3d::Zero());
}

}  // namespace omni::magnetics
