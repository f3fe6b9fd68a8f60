#include "service/haptics/applied/constraint.h"

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;
namespace {

constexpr double kSmallest_m = 1e-9;     // a shorter vector has no direction
constexpr double kDampedFrom_m = 5e-4;   // damping fades in over this stretch, so that reaching the shape does not kick
constexpr double kAdvanceMax_s = 0.050;  // a frame without updates stands still from then on

Stretch Along(const Vec3& outward, double length_m) noexcept {
  return {.length_m = length_m, .outward = outward, .stiff = {Subspace::Shape::kAlong, outward}};
}

// A signed distance s along `ray`: held on the surface, or pushed when beyond it.
Stretch Signed(ConstraintSide side, const Vec3& ray, double s_m) noexcept {
  const Vec3 outward = s_m >= 0 ? ray : -ray;
  if (side == ConstraintSide::kOn) return Along(outward, std::abs(s_m));
  const bool beyond = side == ConstraintSide::kOutside ? s_m < 0 : s_m > 0;
  Stretch stretch = Along(outward, beyond ? std::abs(s_m) : 0);
  stretch.one_sided = true;
  return stretch;
}

Stretch OfPoint(const Vec3& r) noexcept {
  const double length_m = Norm(r);
  return {.length_m = length_m, .outward = length_m > kSmallest_m ? (1 / length_m) * r : Vec3{}};
}

Stretch OfLine(const Constraint& c, const Vec3& r) noexcept {
  const Vec3 across = r - Dot(r, c.direction_base) * c.direction_base;
  Stretch stretch = OfPoint(across);
  if (c.radius_m > 0) {
    stretch = Along(stretch.outward, std::max(0.0, stretch.length_m - c.radius_m));
    stretch.one_sided = true;
  } else {
    stretch.stiff = {Subspace::Shape::kAcross, c.direction_base};
  }
  return stretch;
}

// Within half of the radius the spring fades out towards the centre   (14.4)
Stretch OfSphere(const Constraint& c, const Vec3& r) noexcept {
  const double distance_m = Norm(r);
  if (!(distance_m > kSmallest_m)) {
    return {.one_sided = c.side != ConstraintSide::kOn, .conservative = false, .stiff = {Subspace::Shape::kAlong, {}}};
  }
  Stretch stretch = Signed(c.side, (1 / distance_m) * r, distance_m - c.radius_m);
  stretch.weight = std::min(1.0, 2 * distance_m / c.radius_m);
  stretch.conservative = stretch.weight == 1 || stretch.length_m == 0;
  return stretch;
}

Vec3 AtMost(double most_N, const Vec3& force_N) noexcept {
  const double size_N = Norm(force_N);
  if (!(size_N < 1e12)) return {};
  return size_N > most_N ? (most_N / size_N) * force_N : force_N;
}

}  // namespace

Constraint MovedConstraint(const Constraint& constraint, double after_s) noexcept {
  const double dt_s = std::clamp(after_s, 0.0, kAdvanceMax_s);
  Constraint moved = constraint;
  moved.point_base_m = constraint.point_base_m + dt_s * constraint.velocity_base_m_s;
  const Vec3 turned =
      constraint.direction_base + dt_s * Cross(constraint.angular_velocity_base_rad_s, constraint.direction_base);
  if (Norm(turned) > 0.5) moved.direction_base = Normalized(turned);
  if (after_s > kAdvanceMax_s) moved.velocity_base_m_s = moved.angular_velocity_base_rad_s = {};
  return moved;
}

Vec3 Project(const Subspace& on, const Vec3& v) noexcept {
  const Vec3 along = Dot(v, on.axis) * on.axis;
  switch (on.shape) {
    case Subspace::Shape::kSpace:
      return v;
    case Subspace::Shape::kAcross:
      return v - along;
    case Subspace::Shape::kAlong:
      break;
  }
  return along;
}

// Two planes have a direction in common; a plane and a direction, its part in the plane.
double Overlap(const Subspace& a, const Subspace& b) noexcept {
  const bool one_along = a.shape == Subspace::Shape::kAlong || b.shape == Subspace::Shape::kAlong;
  if (a.shape == Subspace::Shape::kSpace || b.shape == Subspace::Shape::kSpace || !one_along) return 1;
  const double along = Dot(a.axis, b.axis);
  if (a.shape == b.shape) return std::min(1.0, std::abs(along));
  return std::sqrt(std::max(0.0, 1 - along * along));
}

Stretch StretchOf(const Constraint& c, const Vec3& device_point_base_m) noexcept {
  const Vec3 r = device_point_base_m - c.point_base_m;
  switch (c.kind) {
    case ConstraintKind::kPoint:
      return OfPoint(r);
    case ConstraintKind::kLine:
      return OfLine(c, r);
    case ConstraintKind::kPlane:
      return Signed(c.side, c.direction_base, Dot(r, c.direction_base));
    case ConstraintKind::kSphere:
      return OfSphere(c, r);
    case ConstraintKind::kViscous:
      break;
  }
  return {};
}

// F = -w (K s o + b P v), one-sided: never along o   (14.1) - (14.4)
Vec3 ForceOf(const Constraint& c, const Stretch& stretch, double stiffness_N_m, double damping_Ns_m,
             const Vec3& device_point_base_m, const Vec3& velocity_base_m_s) noexcept {
  const Vec3 r = device_point_base_m - c.point_base_m;
  const Vec3 shape_m_s = c.velocity_base_m_s + Cross(c.angular_velocity_base_rad_s, r);
  const Vec3 v = Project(stretch.stiff, velocity_base_m_s - shape_m_s);
  const double grown = stretch.one_sided ? std::min(1.0, stretch.length_m / kDampedFrom_m) : 1.0;
  const double b = stretch.weight * grown * damping_Ns_m;
  const double spring_N = stretch.weight * stiffness_N_m * stretch.length_m;
  if (!stretch.one_sided) return AtMost(c.max_force_N, -spring_N * stretch.outward - b * v);
  const double push_N = std::max(0.0, spring_N + b * Dot(v, stretch.outward));
  return AtMost(c.max_force_N, -push_N * stretch.outward);
}

// U = K s^2 / 2, and along the force limit from there on.
double StoredIn_J(const Constraint& c, const Stretch& stretch, double stiffness_N_m) noexcept {
  if (!(stiffness_N_m > 0)) return 0;
  const double s_m = std::min(stretch.length_m, c.max_force_N / stiffness_N_m);
  return 0.5 * stiffness_N_m * s_m * s_m + c.max_force_N * (stretch.length_m - s_m);
}

}  // namespace omni::haptics
