#include "service/protocol/force_feedback.h"

#include <algorithm>
#include <cmath>

namespace omni::protocol {
namespace {

bool WithinBox(const std::array<double, 3>& v, double limit) noexcept {
  return std::all_of(v.begin(), v.end(), [limit](double x) { return std::abs(x) <= limit; });
}

bool Between(double x, double low, double high) noexcept { return x >= low && x <= high; }

const char* ConstraintProblem(const ForceConstraint& c) noexcept {
  const std::size_t shape = static_cast<std::uint32_t>(c.shape) - std::size_t{1};
  if (shape >= kForceShapes.size()) return "shape is unknown";
  if (c.side > ForceSide::kInside) return "side is not in 0..2";
  if (!Between(c.stiffness_N_m, 0, kLargestStiffness_N_m)) return "stiffness_N_m is not in 0..1e6";
  if (!Between(c.damping_Ns_m, 0, kLargestDamping_Ns_m)) return "damping_Ns_m is not in 0..1e5";
  if (!Between(c.max_force_N, 0, kLargestForce_N)) return "max_force_N is not in 0..1e4";
  if (!Between(c.radius_m, 0, kFarthestConstraint_m)) return "radius_m is not in 0..1e4";
  if (kForceShapes[shape].needs_radius && !(c.radius_m > 0)) return "radius_m is 0 of a shape that needs one";
  if (!WithinBox(c.point_base_m, kFarthestConstraint_m)) return "point_base_m is beyond 1e4";
  const auto& d = c.direction_base;
  const double norm = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  if (!(std::abs(norm - 1) <= kUnitDirectionTolerance)) return "direction_base is no unit vector";
  const bool slow = WithinBox(c.velocity_base_m_s, kFastestConstraint_m_s) &&
                    WithinBox(c.angular_velocity_base_rad_s, kFastestConstraint_m_s);
  return slow ? nullptr : "a velocity is beyond 1e3";
}

}  // namespace

const char* Problem(const ForceClaim& claim) noexcept {
  return claim.wanted <= 1 ? nullptr : "wanted is neither 0 nor 1";
}

const char* Problem(const ForceApply& apply) noexcept {
  if (!(apply.duration_ns >= 1 && apply.duration_ns <= kLongestForce_ns)) return "duration_ns is not in 1..1e8";
  if (!(apply.ramp_ns >= 0 && apply.ramp_ns <= kLongestForce_ns)) return "ramp_ns is not in 0..1e8";
  return WithinBox(apply.force_base_N, kLargestForce_N) ? nullptr : "force_base_N is beyond 1e4";
}

const char* Problem(const ForceConstraints& constraints) noexcept {
  if (constraints.count > kMaxForceConstraints) return "count is above 8";
  for (std::uint32_t i = 0; i < constraints.count; ++i) {
    if (const char* problem = ConstraintProblem(constraints.constraints[i])) return problem;
  }
  return nullptr;
}

const char* Problem(const ForceStop&) noexcept { return nullptr; }

const char* Problem(const ForceOwner& owner) noexcept {
  return owner.standing <= ForceStanding::kTaken ? nullptr : "standing is not in 0..2";
}

const char* Problem(const ForceProperties& properties) noexcept {
  if (properties.available > 1) return "available is neither 0 nor 1";
  if (properties.reach_count > kMaxForceReach) return "reach_count is above 16";
  for (const double value :
       {properties.max_force_N, properties.continuous_force_N, properties.max_stiffness_N_m,
        properties.max_damping_Ns_m, properties.update_rate_Hz, properties.inner_radius_m, properties.outer_radius_m}) {
    if (!Between(value, 0, 1e6)) return "a property is not in 0..1e6";
  }
  for (std::uint32_t i = 0; i < properties.reach_count; ++i) {
    const ForceReach& reach = properties.reach[i];
    if (!(Between(reach.distance_m, 0, 1e6) && Between(reach.force_N, 0, 1e6))) return "a reach is not in 0..1e6";
  }
  return nullptr;
}

}  // namespace omni::protocol
