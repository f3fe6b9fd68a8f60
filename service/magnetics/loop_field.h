// A circular current loop in closed form.
#pragma once

#include <Eigen/Core>

namespace omni::magnetics {

// Complete elliptic integrals of parameter m = k^2 in [0, 1), by the arithmetic-geometric mean.
struct EllipticIntegrals {
  double K = 0;
  double E = 0;
};
EllipticIntegrals CompleteElliptic(double m) noexcept;

// Field (T/A) of a loop of radius `radius_m` about +z, centred at the origin, at cylindrical (rho, z); positive current
// gives a moment along +z. Relative error below 1e-8 everywhere but on the wire itself. docs/theory/magnetics.md (12)
struct LoopField {
  double rho_T_A = 0;
  double z_T_A = 0;
};
LoopField FieldOfLoop(double radius_m, double rho_m, double z_m) noexcept;

// The same as a vector: loop of radius `radius_m` centred at height_m * axis, normal to `axis` (unit), observed at x.
Eigen::Vector3d FieldOfLoop(double radius_m, double height_m, const Eigen::Vector3d& axis,
                            const Eigen::Vector3d& x) noexcept;

}  // namespace omni::magnetics
