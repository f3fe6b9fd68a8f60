// Normalised estimation error squared: is a covariance as large as the errors are? [Bar-Shalom et al. 2001]
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <limits>

#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"
#include "service/sim/fields/charges.h"
#include "service/sim/fields/vec3.h"

namespace omni::bench {

// e^T C^-1 e / 5; C: position, m^2, and along the two tangents of magnetics::MakeTangentBasis(axis), rad^2; row-major.
// NaN: C is not a covariance.
inline double Nees(const sim::MagnetPose& truth, const base::Vec3& position_base_m, const base::Vec3& axis_base,
                   const std::array<double, 25>& C) {
  const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(base::ToEigen(axis_base));
  const base::Vec3 e = position_base_m - truth.centre_base_m;
  const base::Vec3 du = axis_base - truth.axis_base;
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;
  Vector5 error;
  error << base::ToEigen(e), base::ToEigen(du).dot(basis.e1), base::ToEigen(du).dot(basis.e2);
  const Eigen::LLT<Matrix5> factors{Eigen::Map<const Matrix5>(C.data())};
  if (factors.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return error.dot(factors.solve(error)) / 5;
}

}  // namespace omni::bench
