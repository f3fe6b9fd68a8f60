// An axially magnetised cylinder (radius R, half height b, remanence Br) or sphere seen from outside.
#pragma once

#include <Eigen/Core>
#include <array>

#include "service/base/device_geometry.h"

namespace omni::magnetics {

inline constexpr int kMagnetPoints = 5;

// A share of the moment, at offset ring_1 e1 + ring_2 e2 + axial u from the centre; e1, e2, u orthonormal.
struct MagnetPoint {
  double ring_1_m = 0;
  double ring_2_m = 0;
  double axial_m = 0;
  double share = 0;  // of the moment; 0: unused
};

struct DiscMagnet {
  double moment_Am2 = 0;
  // Zonal moments q1, q3, q5 (zonal.h). |B| is within 1.3 % of the exact cylinder at 41 mm with q1, q3 and within
  // 0.15 % with q5; 0.003 % at 80 mm. docs/theory/magnetics.md (8)
  std::array<double, 3> zonal{};
  // Point dipoles with the same q1 and q3: what sources near the magnet (core images, coils) act upon.
  // docs/theory/magnetics.md (9)
  int point_count = 0;
  std::array<MagnetPoint, kMagnetPoints> points{};
};

DiscMagnet MakeDiscMagnet(const base::MagnetGeometry& geometry) noexcept;
// Shape and size of `geometry`, but a measured moment.
DiscMagnet MakeDiscMagnet(const base::MagnetGeometry& geometry, double moment_Am2) noexcept;

// Two unit vectors that complete u to a right-handed orthonormal frame (e1, e2, u), continuous in u but on a small
// circle around +z, where no pen points.
// [Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017]
struct TangentBasis {
  Eigen::Vector3d e1;
  Eigen::Vector3d e2;
};
TangentBasis MakeTangentBasis(const Eigen::Vector3d& u) noexcept;

// The exact field of an axially and uniformly magnetised cylinder (cylinder.cc): what the multipoles are measured
// against. Thirty times slower than those. Valid everywhere but on the two edges (rho = R, z = +-b); inside the magnet
// it is B, not mu0 H.

// Bulirsch's general complete elliptic integral
//   cel(k, p, c, s) = int_0^(pi/2) (c cos^2 t + s sin^2 t) / ((cos^2 t + p sin^2 t) sqrt(cos^2 t + k^2 sin^2 t)) dt,
// k the complementary modulus, k != 0, p > 0. Relative error below 1e-14. [Bulirsch 1969, Numer. Math. 13, 305]
double BulirschCel(double k, double p, double c, double s) noexcept;

// Precondition: a cylinder. `u`: unit axis, d = observation - centre. docs/theory/magnetics.md (16)
Eigen::Vector3d CylinderField(const base::MagnetGeometry& magnet, const Eigen::Vector3d& u,
                              const Eigen::Vector3d& d) noexcept;

}  // namespace omni::magnetics
