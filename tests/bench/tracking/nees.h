// Normalised estimation error squared: is a covariance as large as the errors are? [Bar-Shalom et al. 2001]
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"
#include "service/sim/charges.h"
#include "service/sim/vec3.h"

namespace omni::bench {

// Solves A x = b for a symmetric positive definite 5x5 matrix and returns b^T x; NaN when it is none [Cholesky].
inline double QuadraticOfInverse(std::array<double, 25> A, std::array<double, 5> b) {
  for (std::size_t k = 0; k < 5; ++k) {
    for (std::size_t j = 0; j < k; ++j) A[6 * k] -= A[5 * k + j] * A[5 * k + j];
    A[6 * k] = std::sqrt(A[6 * k]);
    for (std::size_t i = k + 1; i < 5; ++i) {
      for (std::size_t j = 0; j < k; ++j) A[5 * i + k] -= A[5 * i + j] * A[5 * k + j];
      A[5 * i + k] /= A[6 * k];
    }
  }
  double sum = 0;
  for (std::size_t k = 0; k < 5; ++k) {
    for (std::size_t j = 0; j < k; ++j) b[k] -= A[5 * k + j] * b[j];
    b[k] /= A[6 * k];
    sum += b[k] * b[k];
  }
  return sum;
}

// e^T C^-1 e / 5; C: position, m^2, and along the two tangents of magnetics::MakeTangentBasis(axis), rad^2; row-major.
inline double Nees(const sim::MagnetPose& truth, const base::Vec3& position_base_m, const base::Vec3& axis_base,
                   const std::array<double, 25>& C) {
  using sim::operator-;
  const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(base::ToEigen(axis_base));
  const base::Vec3 e = position_base_m - truth.centre_base_m;
  const base::Vec3 du = axis_base - truth.axis_base;
  return QuadraticOfInverse(
             C, {e.x, e.y, e.z, sim::Dot(du, base::FromEigen(basis.e1)), sim::Dot(du, base::FromEigen(basis.e2))}) /
         5;
}

}  // namespace omni::bench
