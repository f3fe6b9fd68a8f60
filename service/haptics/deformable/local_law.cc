#include "service/haptics/deformable/local_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::haptics {
namespace {

// s^3 (1 + g1 s + g2 s^2)
double DentPolynomial(const SoftGain& g, double s) noexcept {
  return s * s * s * (1 + s * (g.linear + s * g.quadratic));
}
double DentPolynomialSlope(const SoftGain& g, double s) noexcept {
  return s * s * (3 + s * (4 * g.linear + s * 5 * g.quadratic));
}

double ForceScale(const LocalLaw& law) noexcept { return 4.0 / 3 * law.modulus_Pa * law.radius_m * law.radius_m; }

}  // namespace

double ContactRadius(double ball_radius_m, double curvature_1_m) noexcept {
  const double curvature = 1 / ball_radius_m + curvature_1_m;
  const double most = 4 / ball_radius_m;
  return 1 / (curvature >= 1 / (4 * ball_radius_m) ? std::min(curvature, most) : 1 / (4 * ball_radius_m));
}

double LocalForce(const LocalLaw& law, double dent_m) noexcept {
  if (!(dent_m > 0)) return 0;
  const double end_m = law.radius_m * kLargestDent * kLargestDent;
  const double s = std::min(std::sqrt(dent_m / law.radius_m), kLargestDent);
  const double force_N = ForceScale(law) * DentPolynomial(law.gain, s);
  return dent_m > end_m ? force_N + (dent_m - end_m) * LocalSlope(law, end_m) : force_N;
}

// dF/dx = dF/ds / (2 R s)
double LocalSlope(const LocalLaw& law, double dent_m) noexcept {
  if (!(dent_m > 0)) return 0;
  const double s = std::min(std::sqrt(dent_m / law.radius_m), kLargestDent);
  return ForceScale(law) * DentPolynomialSlope(law.gain, s) / (2 * law.radius_m * s);
}

double LocalDent(const LocalLaw& law, double force_N) noexcept {
  if (!(force_N > 0)) return 0;
  const double y = force_N / ForceScale(law);
  const double end = DentPolynomial(law.gain, kLargestDent);
  if (y >= end) {
    const double end_m = law.radius_m * kLargestDent * kLargestDent;
    return end_m + (force_N - ForceScale(law) * end) / LocalSlope(law, end_m);
  }
  double s = std::min(std::cbrt(y), kLargestDent);
  for (int step = 0; step < 4; ++step) {
    s -= (DentPolynomial(law.gain, s) - y) / DentPolynomialSlope(law.gain, s);
    s = std::clamp(s, 1e-9, kLargestDent);
  }
  return law.radius_m * s * s;
}

double ContactPatchRadius(const LocalLaw& law, double dent_m) noexcept {
  return std::sqrt(law.radius_m * std::max(dent_m, 0.0));
}

double DentProfile(double r_over_a) noexcept {
  const double r = r_over_a;
  if (!(r > 1)) return 1 - 0.5 * r * r;
  if (r > 30) return 4 / (3 * std::numbers::pi * r);
  return ((2 - r * r) * std::asin(1 / r) + std::sqrt(r * r - 1)) / std::numbers::pi;
}

}  // namespace omni::haptics
