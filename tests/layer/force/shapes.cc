// Constraints from a space into the base frame, over random motions; and which changes of state are events.
#include "layer/src/force/force_rules.h"

#include <gtest/gtest.h>

#include <random>

#include <glm/geometric.hpp>

namespace omni::layer {
namespace test_force_shapes {

using protocol::ForceConstraint;
using protocol::ForceShape;

glm::dvec3 ToVec(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

struct Dice {
  std::mt19937_64 random{11};
  double In(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  glm::dvec3 Vector(double s) { return {In(-s, s), In(-s, s), In(-s, s)}; }
  Motion Place() {
    Motion m;
    m.X.p = Vector(2);
    m.X.q = glm::normalize(glm::dquat(In(-1, 1), In(-1, 1), In(-1, 1), In(0.1, 1)));
    m.v = Vector(0.5);
    m.w = Vector(1);
    return m;
  }
};

// Distance of x from the shape, without radius and side.
double Distance(const ForceConstraint& c, const glm::dvec3& x) {
  const glm::dvec3 r = x - ToVec(c.point_base_m);
  const glm::dvec3 d = ToVec(c.direction_base);
  if (c.shape == ForceShape::kPlane) return glm::dot(r, d);
  if (c.shape == ForceShape::kLine) return glm::length(r - glm::dot(r, d) * d);
  return glm::length(r);
}

TEST(ForceShapes, TransformToBasePreservesDistanceAndMotion) {
  Dice dice;
  for (int run = 0; run < 2000; ++run) {
    ForceConstraint local;
    local.shape = protocol::kForceShapes[static_cast<std::size_t>(run) % protocol::kForceShapes.size()].shape;
    const glm::dvec3 p = dice.Vector(0.5);
    const glm::dvec3 d = glm::normalize(dice.Vector(1));
    local.point_base_m = {p.x, p.y, p.z};
    local.direction_base = {d.x, d.y, d.z};
    const Motion X_BS = dice.Place();
    const ForceConstraint base = InBase(local, X_BS);
    const glm::dvec3 x_S = dice.Vector(0.5);
    const glm::dvec3 x_B = X_BS.X.p + X_BS.X.q * x_S;
    EXPECT_NEAR(Distance(base, x_B), Distance(local, x_S), 1e-12);
    EXPECT_NEAR(glm::length(ToVec(base.direction_base)), 1, 1e-12);
    // A millisecond later the shape has gone along with its space.
    const double dt_s = 1e-3;
    ForceConstraint moved = base;
    const glm::dvec3 point = ToVec(base.point_base_m) + dt_s * ToVec(base.velocity_base_m_s);
    const glm::dvec3 turned =
        glm::normalize(ToVec(base.direction_base) +
                       dt_s * glm::cross(ToVec(base.angular_velocity_base_rad_s), ToVec(base.direction_base)));
    moved.point_base_m = {point.x, point.y, point.z};
    moved.direction_base = {turned.x, turned.y, turned.z};
    Motion later = X_BS;
    later.X.p += dt_s * X_BS.v;
    later.X.q = glm::normalize(ExpRotation(dt_s * X_BS.w) * X_BS.X.q);
    const glm::dvec3 x_later = later.X.p + later.X.q * x_S;
    EXPECT_NEAR(Distance(moved, x_later), Distance(local, x_S), 2e-5) << "run " << run;
  }
}

TEST(ForceShapes, OnlyChangedOrMovingConstraintsAreResent) {
  Dice dice;
  protocol::ForceConstraints a;
  a.count = 1;
  protocol::ForceConstraints b = a;
  b.t_ns = 7;
  EXPECT_TRUE(SameConstraints(a, b)) << "the time alone";
  b.constraints[0].point_base_m[1] = 1e-4;
  EXPECT_FALSE(SameConstraints(a, b));
  b = a;
  b.constraints[0].velocity_base_m_s[0] = 0.1;
  EXPECT_FALSE(SameConstraints(a, b));
  EXPECT_FALSE(SameConstraints(b, b)) << "moving constraints are sent at every sync";
  b = a;
  b.count = 0;
  EXPECT_FALSE(SameConstraints(a, b));
}

constexpr std::int64_t kSecond_ns = 1'000'000'000;

TEST(ForceStatus, ActiveNeedsFocusOwnershipAndADevice) {
  protocol::ToolSample sample;
  ForceSituation situation{
      .focused = true, .standing = protocol::ForceStanding::kYours, .fresh = true, .sample = &sample};
  EXPECT_TRUE(StatusOf(situation).active);
  EXPECT_EQ(StatusOf(situation).flags, 0U);
  ForceSituation other = situation;
  other.focused = false;
  EXPECT_EQ(StatusOf(other).flags, XR_FORCE_FEEDBACK_STATE_FOCUS_LOST_BIT_OMNIX1);
  EXPECT_FALSE(StatusOf(other).active);
  other = situation;
  other.standing = protocol::ForceStanding::kTaken;
  EXPECT_EQ(StatusOf(other).flags, XR_FORCE_FEEDBACK_STATE_IN_USE_BIT_OMNIX1);
  EXPECT_FALSE(StatusOf(other).active);
  other = situation;
  other.fresh = false;
  EXPECT_EQ(StatusOf(other).flags, XR_FORCE_FEEDBACK_STATE_STALE_BIT_OMNIX1);
  EXPECT_FALSE(StatusOf(other).active);
  sample.flags = protocol::kToolDeviceFault | protocol::kToolWarm;
  EXPECT_EQ(StatusOf(situation).flags,
            XR_FORCE_FEEDBACK_STATE_EMERGENCY_STOP_BIT_OMNIX1 | XR_FORCE_FEEDBACK_STATE_THERMAL_LIMITED_BIT_OMNIX1);
  EXPECT_FALSE(StatusOf(situation).active);
}

TEST(ForceStatus, FlickeringFlagClearsAfterHalfASecond) {
  ForceStatusWatch watch({.active = true, .flags = 0});
  const ForceStatus calm{.active = true, .flags = 0};
  const ForceStatus saturated{.active = true, .flags = XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1};
  ForceStatus reported;
  EXPECT_FALSE(watch.Step(calm, kSecond_ns, reported));
  EXPECT_TRUE(watch.Step(saturated, kSecond_ns + 1, reported));
  EXPECT_EQ(reported, saturated);
  int events = 0;
  for (int i = 0; i < 1000; ++i)  // flickers for two seconds
    events += watch.Step(i % 2 == 0 ? calm : saturated, kSecond_ns + i * 2'000'000LL, reported) ? 1 : 0;
  EXPECT_EQ(events, 0);
  EXPECT_FALSE(watch.Step(calm, 3 * kSecond_ns + 400'000'000, reported));
  EXPECT_TRUE(watch.Step(calm, 3 * kSecond_ns + 600'000'000, reported));
  EXPECT_EQ(reported, calm);
  const ForceStatus lost{.active = false, .flags = XR_FORCE_FEEDBACK_STATE_FOCUS_LOST_BIT_OMNIX1};
  EXPECT_TRUE(watch.Step(lost, 4 * kSecond_ns, reported));
  EXPECT_TRUE(watch.Step(calm, 4 * kSecond_ns + 1, reported)) << "focus is reported at once, both ways";
}

}  // namespace test_force_shapes
}  // namespace omni::layer
