// The exact field of an axially and uniformly magnetised cylinder: what the multipoles of disc_magnet.h are measured
// against. Thirty times slower than those. Valid everywhere but on the two edges (rho = R, z = +-b); inside the magnet
// it is B, not mu0 H.
#pragma once

#include <Eigen/Core>

#include "service/base/device_geometry.h"

namespace omni::magnetics {

// Bulirsch's general complete elliptic integral
//   cel(k, p, c, s) = int_0^(pi/2) (c cos^2 t + s sin^2 t) / ((cos^2 t + p sin^2 t) sqrt(cos^2 t + k^2 sin^2 t)) dt,
// k the complementary modulus, k != 0, p > 0. Relative error below 1e-14. [Bulirsch 1969, Numer. Math. 13, 305]
double BulirschCel(double k, double p, double c, double s) noexcept;

// Precondition: a cylinder. `u`: unit axis, d = observation - centre. docs/theory/magnetics.md (16)
Eigen::Vector3d CylinderField(const base::MagnetGeometry& magnet, const Eigen::Vector3d& u,
                              const Eigen::Vector3d& d) noexcept;

}  // namespace omni::magnetics
