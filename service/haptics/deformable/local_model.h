// What happens under one ball on a soft body. Force by local indentation: Hertz's law is the limit of small dents; a
// quadratic gain in s = sqrt(x / R) carries it on to large ones of a neo-Hookean half-space. Then its own dent, the
// displacement of the whole body and a spring, in series. Runs in the tick. docs/theory/deformable.md, sections 5, 6.
#pragma once

namespace omni::haptics {

// Gain over Hertz's law, F / F_Hertz = 1 + g1 s + g2 s^2, of a neo-Hookean half-space under a rigid frictionless ball.
// g1, g2 are quadratic in Poisson's ratio; the constants are the least-squares fit that `omni-bench deformable` repeats
// and prints beside them (side table "gain").   (5.1)
struct SoftGain {
  double linear = 0, quadratic = 0;
};

inline constexpr double kGainLinear[3] = {0.2631, -0.3589, -0.4899};
inline constexpr double kGainQuadratic[3] = {-0.1795, -0.0029, 0.1863};

// nu in [0, 0.49]; `hardening` >= 0 is added to g2 (that is, per x / R).
constexpr SoftGain GainOf(double nu, double hardening) noexcept {
  return {kGainLinear[0] + nu * (kGainLinear[1] + nu * kGainLinear[2]),
          kGainQuadratic[0] + nu * (kGainQuadratic[1] + nu * kGainQuadratic[2]) + hardening};
}

// 1 / R = 1 / ball + curvature of the body (convex > 0), R within [1/4, 4] balls.   (5.2)
double ContactRadius(double ball_radius_m, double curvature_1_m) noexcept;

struct LocalModel {
  double modulus_Pa = 0;  // indentation modulus M, > 0
  double radius_m = 0;    // R of (5.2), > 0
  SoftGain gain;
};

inline constexpr double kDeepest_balls = 4;  // depth beyond this is taken for this
inline constexpr double kLargestDent = 1;    // s up to which the gain was fitted and a bit beyond; linear from there on

// A point of the model.
struct LocalPoint {
  double dent_m = 0;
  double force_N = 0;
  double slope_N_m = 0;  // dF/dx
};

// F = 4/3 M R^2 s^3 (1 + g1 s + g2 s^2), s = sqrt(x / R); all 0 for x <= 0 or NaN.   (5.1)
LocalPoint LocalAtDent(const LocalModel& model, double dent_m) noexcept;
// The dent for a force >= 0: Newton on s, to rounding. `near_m`: a dent near it, which saves iterations; 0: none known.
LocalPoint LocalAtForce(const LocalModel& model, double force_N, double near_m) noexcept;

// Parts of them.
double LocalForce(const LocalModel& model, double dent_m) noexcept;
double LocalSlope(const LocalModel& model, double dent_m) noexcept;
double LocalDent(const LocalModel& model, double force_N) noexcept;

// Radius a of the contact, sqrt(R x).
double ContactPatchRadius(const LocalModel& model, double dent_m) noexcept;

// How far the surface at distance r from the middle of a Hertz pressure of radius a goes in, over the middle. 1 at r =
// 0, about 4 a / (3 pi r) far away [Johnson, Contact Mechanics, 3.42].   (5.4)
double DentProfile(double r_over_a) noexcept;

// How deep a ball goes for a force, and the force of a ball alone.
struct BallCompliance {
  LocalModel model;
  double compliance_m_N = 0;  // of the body here, without the dent; may be negative
  double series_m_N = 0;      // of the spring, >= 0
  double limit_N = 1e300;     // for compliance < 0: from here on only a share of the dent is left   (6.4)
  double limit_dent_m = 1e300;
};

BallCompliance MakeBallCompliance(const LocalModel& model, double compliance_m_N, double series_m_N) noexcept;

struct GivePoint {
  double dent_m = 0;
  double depth_m = 0;    // h(f)
  double slope_m_N = 0;  // h'(f); infinite at no force, there that of a small one
};

// h(f) for a force >= 0. `near_m`: a dent near the answer's, 0: none known.
GivePoint GiveAtForce(const BallCompliance& give, double force_N, double near_m) noexcept;

// The force of one ball alone: h(f) = depth, to rounding. 0 for depths <= 0. `near_m` as above.
double ForceAlone(const BallCompliance& give, double depth_m, double near_m) noexcept;

}  // namespace omni::haptics
