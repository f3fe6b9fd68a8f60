// What happens under the ball itself: force by local indentation. Hertz's law is the limit of small dents; a quadratic
// gain in s = sqrt(x / R) carries it on to large ones of a neo-Hookean half-space. Runs in the tick.
// docs/theory/deformable.md, section 5.
#pragma once

#include "service/haptics/deformable/soft_gain.h"

namespace omni::haptics {

// 1 / R = 1 / ball + curvature of the body (convex > 0), R within [1/4, 4] balls.   (5.2)
double ContactRadius(double ball_radius_m, double curvature_1_m) noexcept;

struct LocalModel {
  double modulus_Pa = 0;  // indentation modulus M, > 0
  double radius_m = 0;    // R of (5.2), > 0
  SoftGain gain;
};

inline constexpr double kLargestDent = 1;  // s up to which the gain was fitted and a bit beyond; linear from there on

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

}  // namespace omni::haptics
