#include "service/actuation/inverse.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace omni::actuation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

}  // namespace

// X^T (X X^T + lambda^2 v v^T)^-1 with v the direction the coils push worst and, for s = sigma_min / sigma_max below
// `singular_ratio` = s0: lambda = sigma_max s0 (1 - (s/s0)^2) / 2   [Maciejewski & Klein 1988, numerical filtering].
// At s = 0 the gain along v is 0; at s = s0 the inverse is exact; in between it is continuous.
DampedInverse InvertForceMap(const std::array<double, 9>& newton_per_ampere, double singular_ratio) noexcept {
  DampedInverse result;
  const Matrix3d X = Eigen::Map<const RowMajor3d>(newton_per_ampere.data());
  if (!X.allFinite()) return result;
  Matrix3d XXt = X * X.transpose();
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(XXt, Eigen::EigenvaluesOnly);  // closed form: no iteration; eigenvalues ascend
  const double largest = eigen.eigenvalues()[2];
  if (!(largest > 0)) return result;
  const double smallest = std::max(0.0, eigen.eigenvalues()[0]);
  result.conditioning = std::sqrt(smallest / largest);
  const double threshold = singular_ratio * singular_ratio * largest;
  result.damped = smallest < threshold;
  Matrix3d inverse;
  if (result.damped) {
    eigen.computeDirect(XXt);
    const Vector3d v = eigen.eigenvectors().col(0);
    const double shortfall = 1 - smallest / threshold;
    XXt += (0.25 * threshold * shortfall * shortfall) * v * v.transpose();
    inverse = X.transpose() * XXt.inverse();
  } else {
    inverse = X.inverse();
  }
  result.valid = inverse.allFinite();
  if (result.valid) Eigen::Map<RowMajor3d>(result.ampere_per_newton.data()) = inverse;
  return result;
}

}  // namespace omni::actuation
