// Zonal multipoles: the field outside any source that is symmetric about an axis u (disc magnet, coil, coil + core).
// Only odd orders occur for sources that are also mirror-antisymmetric: q[j] is the moment of order l = 2 j + 1,
// in A m^(l+1); q[0] is the dipole moment. Valid for |d| beyond the farthest point of the source; the error falls as
// (extent / |d|)^2 per further order.
#pragma once

#include <Eigen/Core>
#include <span>

namespace omni::magnetics {

// The scalars from which field and derivatives are built (docs/theory/magnetics.md (5)), mu0/4pi and powers of r in:
// with A_l = mu0/4pi q_l / r^(l+2), P = P_l(c), beta = (l+1) P + c P', beta' = (l+2) P' + c P'':
struct ZonalSums {
  double p0 = 0;         // sum A P
  double p1 = 0;         // sum A P'
  double p2 = 0;         // sum A P''
  double beta = 0;       // sum A beta
  double beta_d = 0;     // sum A beta'
  double curvature = 0;  // sum A ((l+3) beta + c beta')
};
ZonalSums SumZonal(std::span<const double> q, double r, double c) noexcept;

// B at d from a source with axis u (unit). docs/theory/magnetics.md (4)
Eigen::Vector3d ZonalField(std::span<const double> q, const Eigen::Vector3d& u, const Eigen::Vector3d& d) noexcept;

// dB/dd. docs/theory/magnetics.md (6)
Eigen::Matrix3d ZonalGradient(std::span<const double> q, const Eigen::Vector3d& u, const Eigen::Vector3d& d) noexcept;

// dB/du: change of B when u turns by a small vector perpendicular to u. docs/theory/magnetics.md (7)
Eigen::Matrix3d ZonalAxisDerivative(std::span<const double> q, const Eigen::Vector3d& u,
                                    const Eigen::Vector3d& d) noexcept;

// Scalar potential, B = -grad, T m; and its change when u turns by a small vector perpendicular to u.
// docs/theory/magnetics.md (4)
double ZonalPotential(std::span<const double> q, const Eigen::Vector3d& u, const Eigen::Vector3d& d) noexcept;
Eigen::Vector3d ZonalPotentialAxisDerivative(std::span<const double> q, const Eigen::Vector3d& u,
                                             const Eigen::Vector3d& d) noexcept;

}  // namespace omni::magnetics
