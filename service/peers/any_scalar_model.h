// The measurement model docs/theory/tracking.md (1), written once more for any scalar, so that dual numbers run through
// it. Nothing here is shared with the tracker's kernel but the formulas: agreement of both is a test of both.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::peers {

template <class T>
using V3 = Eigen::Matrix<T, 3, 1>;

// docs/theory/magnetics.md (1); d = observation - source
template <class T>
V3<T> AnyDipole(const V3<T>& m, const V3<T>& d) {
  using std::sqrt;
  const T r2 = d.squaredNorm();
  const T ir3 = 1.0 / (r2 * sqrt(r2));
  return magnetics::kMu0Over4Pi * ir3 * (3.0 * m.dot(d) / r2 * d - m);
}

// docs/theory/magnetics.md (3)
template <class T>
V3<T> AnyCharge(const T& q, const V3<T>& d) {
  using std::sqrt;
  const T r2 = d.squaredNorm();
  return magnetics::kMu0Over4Pi * q / (r2 * sqrt(r2)) * d;
}

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

// Image of a dipole m at P in the core. docs/theory/magnetics.md (10), (11)
template <class T>
struct AnyImage {
  V3<T> place;
  V3<T> moment;
  T charge;
};

template <class T>
AnyImage<T> ImageOf(const V3<T>& m, const V3<T>& P, double core_radius_m, double kappa) {
  using std::sqrt;
  const T r2 = P.squaredNorm();
  const T r = sqrt(r2);
  const V3<T> n = P / r;
  const T mn = m.dot(n);
  const T ratio = core_radius_m / r;
  AnyImage<T> image;
  image.place = ratio * ratio * P;
  image.moment = kappa * ratio * ratio * ratio * (2.0 * mn * n - m);
  image.charge = kappa * core_radius_m * mn / r2;
  return image;
}

// The tangents of magnetics::MakeTangentBasis, so that the ring's points are the tracker's.
template <class T>
void AnyTangents(const V3<T>& u, V3<T>& e1, V3<T>& e2) {
  const double sign = u.z() > T(0.9999) ? 1.0 : -1.0;
  const T a = -1.0 / (sign + u.z());
  const T b = u.x() * u.y() * a;
  e1 = V3<T>(1.0 + sign * u.x() * u.x() * a, sign * b, -sign * u.x());
  e2 = V3<T>(b, sign + u.y() * u.y() * a, -u.y());
}

}  // namespace omni::peers
