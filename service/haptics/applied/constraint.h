// Springs and dampers between the device point and a shape, set by an application. Closed form, at the tick's rate.
// docs/theory/haptics.md, section 14.
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/base/vec.h"

namespace omni::haptics {

enum class ConstraintKind : std::uint8_t { kPoint = 1, kLine = 2, kPlane = 3, kSphere = 4, kViscous = 5 };
inline constexpr std::uint32_t kConstraintKinds = 5;  // their values: from 1 to this

// Of a plane (outside: where its normal points to) or a sphere. Outside and inside only push, and only when the point
// is on the wrong side.
enum class ConstraintSide : std::uint8_t { kOn = 0, kOutside = 1, kInside = 2 };

// Base frame. The shape is fixed to a frame that may move: where it is now follows from where it was and its velocity.
struct Constraint {
  ConstraintKind kind = ConstraintKind::kPoint;
  ConstraintSide side = ConstraintSide::kOn;
  double stiffness_N_m = 0;            // >= 0
  double damping_Ns_m = 0;             // >= 0
  double max_force_N = 0;              // >= 0
  double radius_m = 0;                 // sphere: > 0; line: free within this distance of it
  base::Vec3 point_base_m;             // a point of the shape, or its centre
  base::Vec3 direction_base{0, 0, 1};  // unit: along the line, the plane's normal
  base::Vec3 velocity_base_m_s;        // of that point, with its frame
  base::Vec3 angular_velocity_base_rad_s;
};
static_assert(std::is_trivially_copyable_v<Constraint>);

// The constraint `after_s` later.
Constraint MovedConstraint(const Constraint& constraint, double after_s) noexcept;

// The directions in which a spring is stiff, to first order.
struct Subspace {
  enum class Shape : std::uint8_t { kSpace, kAcross, kAlong };  // all; those across the axis; the axis alone
  Shape shape = Shape::kSpace;
  base::Vec3 axis;  // unit, unless kSpace; zero: kAlong without a direction
};

// P v, P the projection on it.
base::Vec3 Project(const Subspace& on, const base::Vec3& v) noexcept;

// |P_a P_b|, in [0, 1]: 0 if orthogonal.
double Overlap(const Subspace& a, const Subspace& b) noexcept;

// A device point relative to a shape.
struct Stretch {
  bool one_sided = false;    // it never pulls
  bool conservative = true;  // the spring's energy is `elasticity()` of its stretch
  double length_m = 0;       // of the spring, >= 0; 0: it does not act
  double weight = 1;         // of spring and damper: fades where the shape has no direction
  base::Vec3 outward;        // unit: the spring pulls against it; zero: it has no direction
  Subspace stiff;            // of spring and damper; contains `outward`
};
// All that depends on the kind: the rest follows from the stretch.
Stretch StretchOf(const Constraint& constraint, const base::Vec3& device_point_base_m) noexcept;

// Its force on the hand with this stiffness and damping: at most max_force_N, finite.
base::Vec3 ForceOf(const Constraint& constraint, const Stretch& stretch, double stiffness_N_m, double damping_Ns_m,
                   const base::Vec3& device_point_base_m, const base::Vec3& velocity_base_m_s) noexcept;

// Energy in the spring.
double StoredIn_J(const Constraint& constraint, const Stretch& stretch, double stiffness_N_m) noexcept;

}  // namespace omni::haptics
