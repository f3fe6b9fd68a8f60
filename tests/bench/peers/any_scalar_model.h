// The measurement model docs/theory/tracking.md (2.1), written again for any scalar, so that it accepts dual numbers.
// It shares only formulas with the tracker's kernel: agreement of both is a test of both.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::peers {

template <class T>
using V3 = Eigen::Matrix<T, 3, 1>;

// docs/theory/magnetics.md (4) for l = 1, 3, 5
template <class T>
V3<T> AnyZonal(const std::array<double, 3>& q, const V3<T>& u, const V3<T>& d) {
  using std::sqrt;
  const T r2 = d.squaredNorm();
  const T r = sqrt(r2);
  const V3<T> n = d / r;
  const T c = u.dot(n);
  const T c2 = c * c;
  const T P3 = 0.5 * c * (5.0 * c2 - 3.0), P3d = 0.5 * (15.0 * c2 - 3.0);
  const T P5 = 0.125 * c * ((63.0 * c2 - 70.0) * c2 + 15.0), P5d = 0.125 * ((315.0 * c2 - 210.0) * c2 + 15.0);
  const T A1 = magnetics::kMu0Over4Pi * q[0] / (r2 * r);
  const T A3 = magnetics::kMu0Over4Pi * q[1] / (r2 * r2 * r);
  const T A5 = magnetics::kMu0Over4Pi * q[2] / (r2 * r2 * r2 * r);
  const T along_n = A1 * 3.0 * c + A3 * (4.0 * P3 + c * P3d) + A5 * (6.0 * P5 + c * P5d);
  const T along_u = A1 + A3 * P3d + A5 * P5d;
  return along_n * n - along_u * u;
}

// Scalar potential of the same, B = -grad.
template <class T>
T AnyZonalPotential(const std::array<double, 3>& q, const V3<T>& u, const V3<T>& d) {
  using std::sqrt;
  const T r2 = d.squaredNorm();
  const T r = sqrt(r2);
  const T c = u.dot(d) / r;
  const T c2 = c * c;
  const T P3 = 0.5 * c * (5.0 * c2 - 3.0), P5 = 0.125 * c * ((63.0 * c2 - 70.0) * c2 + 15.0);
  return magnetics::kMu0Over4Pi / r2 * (q[0] * c + (q[1] * P3 + q[2] * P5 / r2) / r2);
}

}  // namespace omni::peers
