// `omni follow` without a headset: the probe's lines, the mount, the motion of a base that something carries.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "service/alignment/rigid.h"
#include "service/tools/follow/mount.h"

namespace omni::tools {
namespace test_tools_follow {

using alignment::Compose;
using alignment::Rigid;

constexpr std::int64_t kMs_ns = 1'000'000;

Rigid Turned(const base::Vec3& w, const base::Vec3& p) {
  const double angle = base::Norm(w);
  const double s = angle > 1e-12 ? std::sin(angle / 2) / angle : 0.5;
  return {.orientation = {std::cos(angle / 2), s * w.x, s * w.y, s * w.z}, .position_m = p};
}

const Rigid kMount = Turned({0.4, -1.1, 0.7}, {0.05, -0.12, 0.2});

// Of a source at 0.5 m/s and 90 degrees/s.
const base::Vec3 kVelocity_m_s{0.3, 0.4, 0}, kTurnRate_rad_s{0, 0.94247779608, 1.25663706144};
Rigid SourceAt(double t_s) { return Turned(t_s * kTurnRate_rad_s, t_s * kVelocity_m_s); }

ProbeLine LineAt(std::int64_t t_ns, bool moves) {
  ProbeLine line;
  line.says = ProbeSays::kMotion;
  line.t_ns = t_ns;
  line.pose = SourceAt(1e-9 * static_cast<double>(t_ns));
  line.moves = moves;
  if (moves) {
    line.velocity_m_s = kVelocity_m_s;
    line.turn_rate_rad_s = kTurnRate_rad_s;
  }
  return line;
}

TEST(ToolsFollow, ProbeLinesOfAMotionAreParsed) {
  const auto line = ParseProbeLine("motion 55 0.1 -2 3e-1 0 0 0.6 0.8 1 2 3 -4 5 6");
  ASSERT_TRUE(line);
  EXPECT_EQ(line->says, ProbeSays::kMotion);
  EXPECT_EQ(line->t_ns, 55);
  EXPECT_EQ(line->pose.position_m, (base::Vec3{0.1, -2, 0.3}));
  EXPECT_TRUE(line->moves);
  EXPECT_EQ(line->velocity_m_s, (base::Vec3{1, 2, 3}));
  EXPECT_EQ(line->turn_rate_rad_s, (base::Vec3{-4, 5, 6}));
  EXPECT_EQ(ParseProbeLine("lost")->says, ProbeSays::kLost);
  for (const char* still :
       {"motion 55 0 0 0 0 0 0 1", "motion 55 0 0 0 0 0 0 1 1 2 3", "motion 55 0 0 0 0 0 0 1 1 2 3 4 5 1e9"}) {
    const auto read = ParseProbeLine(still);
    ASSERT_TRUE(read) << still;
    EXPECT_FALSE(read->moves) << still;
    EXPECT_EQ(read->velocity_m_s, base::Vec3{}) << still;
  }
  for (const char* bad : {"motion", "motion x 0 0 0 0 0 0 1", "motion 1 0 0 0 0 0 0 0", "motion 1 left 0 0 0 0 0 0 1"})
    EXPECT_FALSE(ParseProbeLine(bad)) << bad;
}

// The mount that was measured at rest gives the base back wherever its source is.
TEST(ToolsFollow, MountIsFoundFromASourceThatTrembles) {
  std::mt19937 random(3);
  std::normal_distribution<> tremble_m(0, 2e-4), tremble_rad(0, 5e-4);
  const Rigid X_LC = Turned({2.9, 0.3, -0.4}, {0.4, 1.1, -0.3});
  SourceAtRest rest;
  for (std::int64_t t_ns = 0; !rest.complete(); t_ns += 11 * kMs_ns) {
    Rigid seen = Compose(X_LC, Turned({tremble_rad(random), tremble_rad(random), tremble_rad(random)},
                                      {tremble_m(random), tremble_m(random), tremble_m(random)}));
    if (t_ns % 2 == 0)
      seen.orientation = {-seen.orientation.w, -seen.orientation.x, -seen.orientation.y, -seen.orientation.z};
    rest.Add(t_ns, seen);
  }
  const auto mean = rest.Mean();
  ASSERT_TRUE(mean.ok()) << mean.error();
  const Rigid mount = MountOf(*mean, Compose(X_LC, kMount));
  EXPECT_LT(alignment::Distance_m(mount, kMount, {}), 1e-4);
  EXPECT_LT(alignment::Angle_rad(mount, kMount), 3e-4);
}

TEST(ToolsFollow, MountOfASourceThatMovesIsRefused) {
  for (const double speed_m_s : {0.004, 0.5}) {
    SourceAtRest rest;
    for (std::int64_t t_ns = 0; !rest.complete(); t_ns += 11 * kMs_ns)
      rest.Add(t_ns, {.orientation = {}, .position_m = {1e-9 * static_cast<double>(t_ns) * speed_m_s, 0, 0}});
    ASSERT_FALSE(rest.Mean().ok());
    EXPECT_NE(rest.Mean().error().find("at rest"), std::string::npos);
  }
  SourceAtRest turning;
  for (std::int64_t t_ns = 0; !turning.complete(); t_ns += 11 * kMs_ns)
    turning.Add(t_ns, Turned({1e-9 * static_cast<double>(t_ns) * 0.02, 0, 0}, {}));
  EXPECT_FALSE(turning.Mean().ok());
}

// Velocity of the base through its lever, against differences of its poses; also from a runtime that knows none.
TEST(ToolsFollow, VelocityOfTheBaseIsThatOfItsPoses) {
  const Headset headset{.runtime = "R", .system = "S", .space = 3};
  for (const bool moves : {true, false}) {
    CarriedBase carried(headset, kMount);
    for (std::int64_t t_ns = 0; t_ns < 1000 * kMs_ns; t_ns += 5 * kMs_ns) {
      const protocol::BaseMotion motion = carried.MotionAt(LineAt(t_ns, moves));
      ASSERT_EQ(motion.t_ns, t_ns);
      EXPECT_EQ(motion.space, 3);
      EXPECT_STREQ(motion.headset.system, "S");
      EXPECT_EQ(protocol::PoseProblem(motion.base_space), nullptr);
      if (t_ns == 0) continue;
      const double t_s = 1e-9 * static_cast<double>(t_ns);
      const auto at = [](double s) { return Compose(SourceAt(s), kMount).position_m; };
      const base::Vec3 v = 500.0 * (at(t_s + 1e-3) - at(t_s - 1e-3));
      const auto& said = motion.linear_velocity_m_s;
      EXPECT_LT(base::Distance(v, {said[0], said[1], said[2]}), 2e-3) << moves;
      const auto& w = motion.angular_velocity_rad_s;
      EXPECT_LT(base::Distance(kTurnRate_rad_s, {w[0], w[1], w[2]}), 1e-6) << moves;
    }
  }
}

// After a gap the two last poses say nothing of the velocity.
TEST(ToolsFollow, VelocityAcrossAGapIsZero) {
  CarriedBase carried({}, kMount);
  carried.MotionAt(LineAt(0, false));
  for (const double v : carried.MotionAt(LineAt(150 * kMs_ns, false)).linear_velocity_m_s) EXPECT_EQ(v, 0);
}

}  // namespace test_tools_follow
}  // namespace omni::tools
