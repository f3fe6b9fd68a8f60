#include "layer/src/force/force_rules.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace omni::layer {
namespace {

using protocol::ForceConstraint;
using protocol::ForceShape;
using protocol::ForceSide;

constexpr double kSamePlace_m = 1e-6;  // and as direction, m/s, rad/s

glm::dvec3 VecOf(const std::array<double, 3>& v) noexcept { return {v[0], v[1], v[2]}; }

bool NotNegative(float value) noexcept { return std::isfinite(value) && value >= 0; }

template <class T>
const T& As(const XrForceFeedbackConstraintBaseHeaderOMNIX1& header) noexcept {
  return *reinterpret_cast<const T*>(&header);
}

bool ReadDirection(const XrVector3f& direction, ForceConstraint& shape) noexcept {
  const glm::dvec3 d = FromXr(direction);
  const double length = glm::length(d);
  if (!(IsFinite(direction) && length > 1e-20)) return false;
  shape.direction_base = ToArray(d / length);
  return true;
}

bool ReadSide(XrForceFeedbackSideOMNIX1 side, ForceConstraint& shape) noexcept {
  shape.side = static_cast<ForceSide>(side);
  return side >= XR_FORCE_FEEDBACK_SIDE_ON_OMNIX1 && side <= XR_FORCE_FEEDBACK_SIDE_INSIDE_OMNIX1;
}

bool ReadPoint(const XrVector3f& point, ForceConstraint& shape) noexcept {
  shape.point_base_m = ToArray(FromXr(point));
  return IsFinite(point);
}

bool ReadRadius(float radius, ForceConstraint& shape) noexcept {
  shape.radius_m = std::min<double>(radius, protocol::kFarthestConstraint_m);
  return NotNegative(radius);
}

bool ReadPointShape(const XrForceFeedbackConstraintBaseHeaderOMNIX1& header, ForceConstraint& shape) noexcept {
  return ReadPoint(As<XrForceFeedbackConstraintPointOMNIX1>(header).position, shape);
}

bool ReadLine(const XrForceFeedbackConstraintBaseHeaderOMNIX1& header, ForceConstraint& shape) noexcept {
  const auto& line = As<XrForceFeedbackConstraintLineOMNIX1>(header);
  return ReadPoint(line.position, shape) && ReadDirection(line.direction, shape) && ReadRadius(line.radius, shape);
}

bool ReadPlane(const XrForceFeedbackConstraintBaseHeaderOMNIX1& header, ForceConstraint& shape) noexcept {
  const auto& plane = As<XrForceFeedbackConstraintPlaneOMNIX1>(header);
  return ReadPoint(plane.position, shape) && ReadDirection(plane.normal, shape) && ReadSide(plane.side, shape);
}

bool ReadSphere(const XrForceFeedbackConstraintBaseHeaderOMNIX1& header, ForceConstraint& shape) noexcept {
  const auto& sphere = As<XrForceFeedbackConstraintSphereOMNIX1>(header);
  return ReadPoint(sphere.position, shape) && ReadRadius(sphere.radius, shape) && sphere.radius > 0 &&
         ReadSide(sphere.side, shape);
}

bool ReadViscous(const XrForceFeedbackConstraintBaseHeaderOMNIX1& header, ForceConstraint&) noexcept {
  return header.stiffness == 0;
}

// The point of a shape's points that is nearest to the base's origin: its other points give the same shape.
glm::dvec3 Itself(const glm::dvec3& p, const glm::dvec3&) noexcept { return p; }
glm::dvec3 OfLine(const glm::dvec3& p, const glm::dvec3& d) noexcept { return p - glm::dot(p, d) * d; }
glm::dvec3 OfPlane(const glm::dvec3& p, const glm::dvec3& d) noexcept { return glm::dot(p, d) * d; }

struct ShapeRow {
  int type;  // XrStructureType; some are the extension's own, in no enumeration
  bool (*read)(const XrForceFeedbackConstraintBaseHeaderOMNIX1&, ForceConstraint&) noexcept;
  glm::dvec3 (*nearest)(const glm::dvec3& point, const glm::dvec3& direction) noexcept;
};
// In the order of protocol::kForceShapes.
constexpr std::array kShapes{
    ShapeRow{XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_POINT_OMNIX1, ReadPointShape, Itself},
    ShapeRow{XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_LINE_OMNIX1, ReadLine, OfLine},
    ShapeRow{XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_PLANE_OMNIX1, ReadPlane, OfPlane},
    ShapeRow{XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_SPHERE_OMNIX1, ReadSphere, Itself},
    ShapeRow{XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_VISCOUS_OMNIX1, ReadViscous, Itself},
};
static_assert(kShapes.size() == protocol::kForceShapes.size());

bool ReadShape(const XrForceFeedbackConstraintBaseHeaderOMNIX1& header, ForceConstraint& shape) noexcept {
  for (std::size_t i = 0; i < kShapes.size(); ++i) {
    if (static_cast<int>(header.type) != kShapes[i].type) continue;
    shape.shape = protocol::kForceShapes[i].shape;
    return kShapes[i].read(header, shape);
  }
  return false;
}

const ShapeRow& RowOf(ForceShape shape) noexcept {
  return kShapes[static_cast<std::size_t>(shape) - static_cast<std::size_t>(protocol::kForceShapes[0].shape)];
}

bool Near(const std::array<double, 3>& a, const std::array<double, 3>& b) noexcept {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(std::abs(a[i] - b[i]) <= kSamePlace_m)) return false;
  }
  return true;
}

bool SameAndStill(const ForceConstraint& a, const ForceConstraint& b) noexcept {
  const bool same_feel = a.shape == b.shape && a.side == b.side && a.stiffness_N_m == b.stiffness_N_m &&
                         a.damping_Ns_m == b.damping_Ns_m && a.max_force_N == b.max_force_N && a.radius_m == b.radius_m;
  return same_feel && Near(a.point_base_m, b.point_base_m) && Near(a.direction_base, b.direction_base) &&
         Near(b.velocity_base_m_s, {}) && Near(b.angular_velocity_base_rad_s, {}) && Near(a.velocity_base_m_s, {}) &&
         Near(a.angular_velocity_base_rad_s, {});
}

std::int64_t GoneAfter_ns() noexcept { return 500'000'000; }

// What an application is shown of a flag of the sample; 0: nothing.
constexpr XrForceFeedbackStateFlagsOMNIX1 StateBitOf(protocol::ToolFlag flag) noexcept {
  switch (flag) {
    case protocol::kToolForceCut:
      return XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1;
    case protocol::kToolWarm:
      return XR_FORCE_FEEDBACK_STATE_THERMAL_LIMITED_BIT_OMNIX1;
    case protocol::kToolOutOfReach:
      return XR_FORCE_FEEDBACK_STATE_OUT_OF_WORKSPACE_BIT_OMNIX1;
    case protocol::kToolDeviceFault:
      return XR_FORCE_FEEDBACK_STATE_EMERGENCY_STOP_BIT_OMNIX1;
    case protocol::kToolStiffnessLimited:
      return XR_FORCE_FEEDBACK_STATE_STIFFNESS_LIMITED_BIT_OMNIX1;
    case protocol::kToolPoseValid:
    case protocol::kToolTracked:
    case protocol::kToolContact:
    case protocol::kToolJoystick:
    case protocol::kToolAligned:
    case protocol::kToolPushed:
    case protocol::kToolHolding:
    case protocol::kToolSoftened:
    case protocol::kToolWaits:
      return 0;
  }
  return 0;
}

// Those that flicker with the hand's motion.
constexpr std::array<XrForceFeedbackStateFlagsOMNIX1, 4> kFleeting{
    XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1, XR_FORCE_FEEDBACK_STATE_THERMAL_LIMITED_BIT_OMNIX1,
    XR_FORCE_FEEDBACK_STATE_OUT_OF_WORKSPACE_BIT_OMNIX1, XR_FORCE_FEEDBACK_STATE_STIFFNESS_LIMITED_BIT_OMNIX1};

}  // namespace

XrResult ReadConstraints(const XrForceFeedbackConstraintsSetInfoOMNIX1& info, std::vector<LocalConstraint>& out) {
  out.clear();
  if (info.constraintCount > 0 && !info.constraints) return XR_ERROR_VALIDATION_FAILURE;
  const std::uint32_t count = std::min<std::uint32_t>(info.constraintCount, XR_MAX_FORCE_FEEDBACK_CONSTRAINTS_OMNIX1);
  if (info.constraintCount > count) return XR_ERROR_LIMIT_REACHED;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto* header = info.constraints[i];
    if (!header || !NotNegative(header->stiffness) || !NotNegative(header->damping) || !NotNegative(header->maxForce))
      return XR_ERROR_VALIDATION_FAILURE;
    LocalConstraint constraint;
    constraint.space = header->baseSpace;
    constraint.shape.stiffness_N_m = std::min<double>(header->stiffness, protocol::kLargestStiffness_N_m);
    constraint.shape.damping_Ns_m = std::min<double>(header->damping, protocol::kLargestDamping_Ns_m);
    constraint.shape.max_force_N = std::min<double>(header->maxForce, protocol::kLargestForce_N);
    if (!ReadShape(*header, constraint.shape)) return XR_ERROR_VALIDATION_FAILURE;
    if (constraint.space == XR_NULL_HANDLE) return XR_ERROR_HANDLE_INVALID;
    out.push_back(constraint);
  }
  return XR_SUCCESS;
}

std::array<double, 3> Clamped(const glm::dvec3& v, double limit) noexcept {
  std::array<double, 3> out = ToArray(v);
  for (double& x : out) x = std::isfinite(x) ? std::clamp(x, -limit, limit) : 0;
  return out;
}

// v = v_S + w x R p
protocol::ForceConstraint InBase(const protocol::ForceConstraint& shape, const Motion& X_BS) noexcept {
  protocol::ForceConstraint out = shape;
  const glm::dvec3 d = glm::normalize(X_BS.X.q * VecOf(shape.direction_base));
  const glm::dvec3 p = RowOf(shape.shape).nearest(X_BS.X.p + X_BS.X.q * VecOf(shape.point_base_m), d);
  out.direction_base = ToArray(d);
  out.point_base_m = Clamped(p, protocol::kFarthestConstraint_m);
  out.velocity_base_m_s = Clamped(X_BS.v + glm::cross(X_BS.w, p - X_BS.X.p), protocol::kFastestConstraint_m_s);
  out.angular_velocity_base_rad_s = Clamped(X_BS.w, protocol::kFastestConstraint_m_s);
  return out;
}

bool SameConstraints(const protocol::ForceConstraints& sent, const protocol::ForceConstraints& now) noexcept {
  if (sent.count != now.count) return false;
  return std::equal(sent.constraints.begin(), sent.constraints.begin() + sent.count, now.constraints.begin(),
                    SameAndStill);
}

ForceStatus StatusOf(const ForceSituation& situation) noexcept {
  ForceStatus status;
  const bool fresh = situation.fresh && situation.sample;
  if (!situation.focused) status.flags |= XR_FORCE_FEEDBACK_STATE_FOCUS_LOST_BIT_OMNIX1;
  if (!fresh) status.flags |= XR_FORCE_FEEDBACK_STATE_STALE_BIT_OMNIX1;
  if (situation.standing == protocol::ForceStanding::kTaken) status.flags |= XR_FORCE_FEEDBACK_STATE_IN_USE_BIT_OMNIX1;
  for (std::uint32_t left = situation.sample ? situation.sample->flags : 0; left != 0; left &= left - 1)
    status.flags |= StateBitOf(static_cast<protocol::ToolFlag>(left & -left));
  status.active = situation.focused && fresh && situation.standing == protocol::ForceStanding::kYours &&
                  !(status.flags & XR_FORCE_FEEDBACK_STATE_EMERGENCY_STOP_BIT_OMNIX1);
  return status;
}

bool ForceStatusWatch::Step(const ForceStatus& now, std::int64_t now_ns, ForceStatus& reported) noexcept {
  ForceStatus status = now;
  for (std::size_t i = 0; i < kFleeting.size(); ++i) {
    if (now.flags & kFleeting[i]) seen_ns_[i] = now_ns;
    if (now_ns - seen_ns_[i] < GoneAfter_ns()) status.flags |= reported_.flags & kFleeting[i];
  }
  if (status == reported_) return false;
  reported = reported_ = status;
  return true;
}

}  // namespace omni::layer
