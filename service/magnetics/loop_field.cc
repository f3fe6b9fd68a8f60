#include "service/magnetics/loop_field.h"

#include <cmath>
#include <numbers>

#include "service/magnetics/dipole.h"

namespace omni::magnetics {

// a0 = 1, g0 = sqrt(1 - m), c0^2 = m: K = pi / (2 a_n), E = K (1 - sum 2^(n-1) c_n^2)   [Abramowitz & Stegun 17.6]
EllipticIntegrals CompleteElliptic(double m) noexcept {
  double a = 1;
  double g = std::sqrt(1 - m);
  double weight = 0.5;
  double sum = weight * m;
  for (int n = 0; n < 12; ++n) {
    const double c = 0.5 * (a - g);
    const double next = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = next;
    weight *= 2;
    sum += weight * c * c;
    if (!(std::abs(c) > 1e-16 * a)) break;
  }
  const double K = 0.5 * std::numbers::pi / a;
  return {K, K * (1 - sum)};
}

// k^2 = 4 a rho / s, s = (a + rho)^2 + z^2, t = (a - rho)^2 + z^2:
//   Bz   = mu0/2pi 1/sqrt(s) [K + (a^2 - rho^2 - z^2)/t E]
//   Brho = mu0/2pi z/(rho sqrt(s)) [-K + (a^2 + rho^2 + z^2)/t E]   [Smythe, Static and Dynamic Electricity, 7.10]
// Near the axis the bracket of Brho cancels; there Brho = -rho/2 dBz/dz with Bz = mu0 a^2 / (2 (a^2 + z^2)^(3/2)).
LoopField FieldOfLoop(double radius_m, double rho_m, double z_m) noexcept {
  const double a = radius_m;
  const double s = (a + rho_m) * (a + rho_m) + z_m * z_m;
  const double t = (a - rho_m) * (a - rho_m) + z_m * z_m;
  const EllipticIntegrals e = CompleteElliptic(4 * a * rho_m / s);
  const double scale = kMu0 / (2 * std::numbers::pi * std::sqrt(s));
  const double a2 = a * a;
  const double rest = rho_m * rho_m + z_m * z_m;
  const double Bz = scale * (e.K + (a2 - rest) / t * e.E);
  if (rho_m < 1e-4 * std::sqrt(a2 + z_m * z_m)) {
    const double h2 = a2 + z_m * z_m;
    return {0.75 * kMu0 * a2 * rho_m * z_m / (h2 * h2 * std::sqrt(h2)), Bz};
  }
  return {scale * z_m / rho_m * ((a2 + rest) / t * e.E - e.K), Bz};
}

Eigen::Vector3d FieldOfLoop(double radius_m, double height_m, const Eigen::Vector3d& axis,
                            const Eigen::Vector3d& x) noexcept {
  const double z = axis.dot(x);
  const Eigen::Vector3d radial = x - z * axis;
  const double rho = radial.norm();
  const LoopField B = FieldOfLoop(radius_m, rho, z - height_m);
  if (!(rho > 0)) return B.z_T_A * axis;
  return B.z_T_A * axis + (B.rho_T_A / rho) * radial;
}

}  // namespace omni::magnetics
