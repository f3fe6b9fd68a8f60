#include "service/magnetics/disc_magnet.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/magnetics/coil.h"
#include "service/magnetics/dipole.h"

namespace omni::magnetics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNearAxis = 1e-4;    // of the distance to the edge: below, Brho = -rho/2 dBz/dz
constexpr double kNearMantle = 1e-9;  // of R: below, gamma = 0 would divide 0 by 0

// d in the magnet's own cylinder coordinates.
struct Seen {
  Vector3d n_rho;  // unit, away from the axis; zero on it
  double rho = 0, z = 0;
  bool near_axis = false;
};

Seen SeenFrom(const base::MagnetGeometry& magnet, const Vector3d& u, const Vector3d& d) noexcept {
  Seen seen;
  seen.z = u.dot(d);
  const Vector3d across = d - seen.z * u;
  seen.rho = across.norm();
  seen.n_rho = seen.rho > 0 ? Vector3d(across / seen.rho) : Vector3d(Vector3d::Zero());
  const double R = magnet.radius_m;
  seen.near_axis = !(seen.rho > kNearAxis * std::hypot(R, std::abs(seen.z) - magnet.half_height_m));
  if (std::abs(seen.rho - R) < kNearMantle * R) seen.rho = R * (1 + kNearMantle);
  return seen;
}

struct RhoZ {
  double rho = 0, z = 0;
};

// The cylinder is a sheet of current Br/mu0 per length around its mantle, so a shift along z takes one loop away at the
// far end and adds one at the near: dBz/dz = Br/mu0 [ B_loop(z + b) - B_loop(z - b) ].   docs/theory/magnetics.md (17)
double AxialDerivative_T_m(const base::MagnetGeometry& magnet, const Seen& at) noexcept {
  const double sheet_A_m = magnet.remanence_T / kMu0;
  const LoopField near = FieldOfLoop(magnet.radius_m, at.rho, at.z + magnet.half_height_m);
  const LoopField far = FieldOfLoop(magnet.radius_m, at.rho, at.z - magnet.half_height_m);
  return sheet_A_m * (near.z_T_A - far.z_T_A);
}

// B0 = Br/pi, z+- = z +- b, s+- = sqrt(z+-^2 + (rho + R)^2), g = (R - rho)/(R + rho), k+-^2 = (z+-^2 + (R -
// rho)^2)/s+-^2:
//   Brho = B0 [ R/s+ C(k+, 1, 1, -1) - R/s- C(k-, 1, 1, -1) ]
//   Bz   = B0 R/(R + rho) [ z+/s+ C(k+, g^2, 1, g) - z-/s- C(k-, g^2, 1, g) ]    [Derby & Olbert 2010, Am. J. Phys. 78,
//   229]
RhoZ InCylinderCoordinates(const base::MagnetGeometry& magnet, const Seen& at) noexcept {
  const double R = magnet.radius_m;
  const double gamma = (R - at.rho) / (R + at.rho);
  RhoZ B;
  for (const double side : {1.0, -1.0}) {
    const double z = at.z + side * magnet.half_height_m;
    const double s = std::hypot(z, at.rho + R);
    const double k = std::hypot(z, R - at.rho) / s;
    B.rho += side * (R / s) * BulirschCel(k, 1, 1, -1);
    B.z += side * (z / s) * BulirschCel(k, gamma * gamma, 1, gamma);
  }
  const double B0 = magnet.remanence_T / std::numbers::pi;
  return {B0 * B.rho, B0 * R / (R + at.rho) * B.z};
}

}  // namespace

// Bartky's transformation, repeated until the moduli meet.
double BulirschCel(double k, double p, double c, double s) noexcept {
  constexpr double kTolerance = 1e-8;  // converges quadratically: what is left is its square
  constexpr int kRoundsMax = 30;       // 5 or 6 are usual; 30 for k near 1e-300
  double mean = 1, modulus = std::abs(k), product = modulus;
  double pp = std::sqrt(p), ss = s / pp, cc = c;
  for (int round = 0; round < kRoundsMax; ++round) {
    const double c_before = cc, mean_before = mean;
    const double g = product / pp;
    cc += ss / pp;
    ss = 2 * (ss + c_before * g);
    pp += g;
    mean += modulus;
    if (!(std::abs(mean_before - modulus) > kTolerance * mean_before)) break;
    modulus = 2 * std::sqrt(product);
    product = modulus * mean;
  }
  return 0.5 * std::numbers::pi * (ss + cc * mean) / (mean * (mean + pp));
}

Vector3d CylinderField(const base::MagnetGeometry& magnet, const Vector3d& u, const Vector3d& d) noexcept {
  const Seen at = SeenFrom(magnet, u, d);
  RhoZ B = InCylinderCoordinates(magnet, at);
  if (at.near_axis) B.rho = -0.5 * at.rho * AxialDerivative_T_m(magnet, at);
  return B.rho * at.n_rho + B.z * u;
}

}  // namespace omni::magnetics
