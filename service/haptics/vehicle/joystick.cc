#include "service/haptics/vehicle/joystick.h"

#include <numbers>

namespace omni::haptics {
namespace {

constexpr double kEdgeShare = 0.3;  // of the dead zone: the spring sets in over this width around its edge

double Travel(const JoystickInput& joystick) noexcept { return joystick.range_m - joystick.dead_zone_m; }

// (r - dead)+ with the kink at the edge made a parabola of width w: continuous slope, exact from dead + w/2 on   (7.2)
double Stretch(double r_m, double dead_m) noexcept {
  const double half_m = 0.5 * kEdgeShare * dead_m;
  const double s = r_m - dead_m;
  if (s >= half_m) return s;
  if (s <= -half_m) return 0;
  return (s + half_m) * (s + half_m) / (4 * half_m);
}

}  // namespace

// F = -K stretch(|u|) u/|u| - B v + c F_detent, c so that K and the notches together stay within the limit   (7.1)
Vec3 JoystickForce(const JoystickInput& joystick, double detent_curvature_N_m, const StiffnessBound& bound,
                   const Input& input) noexcept {
  const double limit_N_m = bound.stiffness_N_m;
  const double stiffness_N_m = std::clamp(joystick.stiffness_N_m, 0.0, limit_N_m);
  const double damping_Ns_m = std::clamp(joystick.damping_Ns_m, 0.0, bound.damping_Ns_m);
  const Vec3 u = input.device_point_base_m - joystick.centre_base_m;
  Vec3 force_N =
      -stiffness_N_m * Stretch(Norm(u), joystick.dead_zone_m) * Normalized(u) - damping_Ns_m * input.velocity_base_m_s;
  if (!(detent_curvature_N_m > 0)) return force_N;
  const double left_N_m = limit_N_m - stiffness_N_m;
  return force_N + std::min(1.0, left_N_m / detent_curvature_N_m) * DetentForce(joystick, u);
}

// Only the lateral displacement counts: (|u_xy| - dead) / (range - dead), at most 1   (7.5)
Thumbstick JoystickDeflection(const JoystickInput& joystick, const Vec3& tip) noexcept {
  const double x = tip.x - joystick.centre_base_m.x;
  const double y = tip.y - joystick.centre_base_m.y;
  const double r = std::sqrt(x * x + y * y);
  const double travel_m = Travel(joystick);
  if (!(r > joystick.dead_zone_m && travel_m > 0)) return {};
  const double deflection = std::min(1.0, (r - joystick.dead_zone_m) / travel_m);
  return {deflection * x / r, deflection * y / r};
}

// Force of the potential U = S L / (2 pi n) w(p) (1 - cos 2 pi n p) + S R / m w(p) (1 - cos m a),
// p = deflection, a = angle from +y, L = travel, R = range, w = 3 p^2 - 2 p^3 in [0, 1]   (7.3)
Vec3 DetentForce(const JoystickInput& joystick, const Vec3& u) noexcept {
  const double r = std::sqrt(u.x * u.x + u.y * u.y), travel_m = Travel(joystick);
  const double p = (r - joystick.dead_zone_m) / travel_m;
  if (!(p > 0 && joystick.detent_force_N > 0)) return {};
  const double inside = std::min(p, 1.0);
  const double window = inside * inside * (3 - 2 * inside);
  const double slope_1_m = p < 1 ? 6 * inside * (1 - inside) / travel_m : 0;
  double radial_N = 0, tangential_N = 0;  // outwards; towards larger angles
  if (joystick.radial_detents > 0 && p < 1) {
    const double turns = 2 * std::numbers::pi * joystick.radial_detents;
    const double height = joystick.detent_force_N * travel_m / turns;
    radial_N -= height * (slope_1_m * (1 - std::cos(turns * p)) + window * turns / travel_m * std::sin(turns * p));
  }
  if (joystick.angular_detents > 0) {
    const double m = joystick.angular_detents, angle = std::atan2(u.x, u.y);
    const double height = joystick.detent_force_N * joystick.range_m / m;
    radial_N -= height * slope_1_m * (1 - std::cos(m * angle));
    tangential_N -= height * window * m * std::sin(m * angle) / r;
  }
  const Vec3 out{u.x / r, u.y / r, 0}, round{out.y, -out.x, 0};
  return radial_N * out + tangential_N * round;
}

// Largest eigenvalue (in size) of the symmetric part of dF/du, by central differences over the plane   (7.4)
double DetentCurvature_N_m(const JoystickInput& joystick) {
  if (!(joystick.detent_force_N > 0) || joystick.radial_detents + joystick.angular_detents <= 0) return 0;
  constexpr int kRadii = 240, kAngles = 48;
  constexpr double kMargin = 1.02;  // between the places sampled
  const double step_m = 1e-5 * Travel(joystick);
  double largest_N_m = 0;
  for (int i = 1; i < kRadii; ++i) {
    const double r = joystick.dead_zone_m + 1.2 * Travel(joystick) * i / kRadii;
    for (int k = 0; k < kAngles; ++k) {
      // One period of the angular notches is enough.
      const double angle = 2 * std::numbers::pi * k / (kAngles * std::max(1, joystick.angular_detents));
      const Vec3 u{r * std::sin(angle), r * std::cos(angle), 0};
      const Vec3 by_x = DetentForce(joystick, u + Vec3{step_m, 0, 0}) - DetentForce(joystick, u - Vec3{step_m, 0, 0});
      const Vec3 by_y = DetentForce(joystick, u + Vec3{0, step_m, 0}) - DetentForce(joystick, u - Vec3{0, step_m, 0});
      const double mean = 0.5 * (by_x.x + by_y.y), half = 0.5 * (by_x.x - by_y.y), shear = 0.5 * (by_x.y + by_y.x);
      largest_N_m = std::max(largest_N_m, std::abs(mean) + std::sqrt(half * half + shear * shear));
    }
  }
  return kMargin * largest_N_m / (2 * step_m);
}

}  // namespace omni::haptics
