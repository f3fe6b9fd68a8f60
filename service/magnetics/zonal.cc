#include "service/magnetics/zonal.h"

#include "service/magnetics/dipole.h"

namespace omni::magnetics {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// P_(l+1) = ((2l+1) c P_l - l P_(l-1)) / (l+1), P'_(l+1) = P'_(l-1) + (2l+1) P_l and the same once more for P''
// [Abramowitz & Stegun 8.5.3, 8.5.4].
ZonalSums SumZonal(std::span<const double> q, double r, double c) noexcept {
  const double inverse_r2 = 1 / (r * r);
  double scale = kMu0Over4Pi * inverse_r2 / r;  // mu0/4pi / r^(l+2) at l = 1
  double P_below = 1, P1_below = 0, P2_below = 0;
  double P = c, P1 = 1, P2 = 0;
  ZonalSums sums;
  double l = 1;
  for (const double moment : q) {
    const double A = scale * moment;
    const double beta = (l + 1) * P + c * P1;
    const double beta_d = (l + 2) * P1 + c * P2;
    sums.p0 += A * P;
    sums.p1 += A * P1;
    sums.p2 += A * P2;
    sums.beta += A * beta;
    sums.beta_d += A * beta_d;
    sums.curvature += A * ((l + 3) * beta + c * beta_d);
    scale *= inverse_r2;
    for (int twice = 0; twice < 2; ++twice, l += 1) {
      const double P_above = ((2 * l + 1) * c * P - l * P_below) / (l + 1);
      const double P1_above = P1_below + (2 * l + 1) * P;
      const double P2_above = P2_below + (2 * l + 1) * P1;
      P_below = P, P1_below = P1, P2_below = P2;
      P = P_above, P1 = P1_above, P2 = P2_above;
    }
  }
  return sums;
}

// B = sum A [(l+1) P n - P' (u - c n)] = sum A (beta n - P' u), n = d/r: minus the gradient of q P_l(c) / r^(l+1)
// [Jackson 3e, 3.3 and 4.1].
Vector3d ZonalField(std::span<const double> q, const Vector3d& u, const Vector3d& d) noexcept {
  const double r = d.norm();
  const Vector3d n = d / r;
  const ZonalSums s = SumZonal(q, r, u.dot(n));
  return s.beta * n - s.p1 * u;
}

// G = -1/r sum A { P'' u u^T - beta' (u n^T + n u^T) + [(l+3) beta + c beta'] n n^T - beta I }
// Check l = 1: 3e-7 q / r^4 [c I + u n^T + n u^T - 5 c n n^T], which is (2).
Matrix3d ZonalGradient(std::span<const double> q, const Vector3d& u, const Vector3d& d) noexcept {
  const double r = d.norm();
  const Vector3d n = d / r;
  const ZonalSums s = SumZonal(q, r, u.dot(n));
  const Matrix3d un_T = u * n.transpose();
  return (-1 / r) * (s.p2 * u * u.transpose() - s.beta_d * (un_T + un_T.transpose()) + s.curvature * n * n.transpose() -
                     s.beta * Matrix3d::Identity());
}

// dB/du = sum A (beta' n n^T - P'' u n^T - P' I)
Matrix3d ZonalAxisDerivative(std::span<const double> q, const Vector3d& u, const Vector3d& d) noexcept {
  const double r = d.norm();
  const Vector3d n = d / r;
  const ZonalSums s = SumZonal(q, r, u.dot(n));
  return s.beta_d * n * n.transpose() - s.p2 * u * n.transpose() - s.p1 * Matrix3d::Identity();
}

// phi = r sum A P, and r n = d.
double ZonalPotential(std::span<const double> q, const Vector3d& u, const Vector3d& d) noexcept {
  const double r = d.norm();
  return r * SumZonal(q, r, u.dot(d) / r).p0;
}

Vector3d ZonalPotentialAxisDerivative(std::span<const double> q, const Vector3d& u, const Vector3d& d) noexcept {
  const double r = d.norm();
  return SumZonal(q, r, u.dot(d) / r).p1 * d;
}

}  // namespace omni::magnetics
