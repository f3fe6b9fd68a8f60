// omni try: the hand pushes with what the base can make, and no more.
#include "service/monitor/trial/trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace omni::monitor {
namespace {

constexpr double kHand_N_m = 150, kHandDamping_Ns_m = 3, kMass_kg = 0.12;
constexpr double kLed_m_s = 0.2;
constexpr double kTick_s = 1e-3;
constexpr int kTicksPerFeel = 16;

// A level surface at height 0 under a hand that is led straight down onto it: one axis, by explicit Euler.
struct Press {
  double wall_N_m = 600, base_N = 1.1;  // what the base can make; may change
  double z_m = 0.02, velocity_m_s = 0;
  double deepest_m = 0, force_N = 0;
  double led_m = 0.02;  // far end of the hand's spring: follows the aim
  AimLimit limit{{.hand_stiffness_N_m = kHand_N_m, .force_max_N = 2}};
  protocol::HandAim asked, aim;

  void Hold(double seconds, bool limited) {
    for (int k = 0; k < static_cast<int>(seconds / kTick_s); ++k) {
      const double asked_N = std::max(0.0, -wall_N_m * z_m);
      force_N = std::min(asked_N, base_N);
      if (k % kTicksPerFeel == 0 && limited) Feel(asked_N);
      led_m += std::clamp(aim.tip_base_m[2] - led_m, -kLed_m_s * kTick_s, kLed_m_s * kTick_s);
      const double pull_N = kHand_N_m * (led_m - z_m) - kHandDamping_Ns_m * velocity_m_s;
      velocity_m_s += kTick_s * (pull_N + force_N) / kMass_kg;
      z_m += kTick_s * velocity_m_s;
      deepest_m = std::max(deepest_m, -z_m);
    }
  }

  void Feel(double asked_N) {
    protocol::ToolSample tool;
    tool.flags = protocol::kToolPoseValid | protocol::kToolTracked;
    if (asked_N > base_N) tool.flags |= protocol::kToolForceCut;
    tool.force_base_N[2] = force_N;
    tool.position_base_m[2] = z_m;
    protocol::ContactSnapshot contacts;
    contacts.count = asked_N > 0 ? 1 : 0;
    contacts.contacts[0].normal_base = {0, 0, 1};
    contacts.contacts[0].penetration_m = std::max(0.0, -z_m);
    limit.Update(tool, contacts, kTicksPerFeel * kTick_s);
    aim = limit.LimitAim(asked);
  }
};

TEST(AimLimit, HandIsNotPushedThroughAndFeelsWhatTheBaseCanMake) {
  for (const double base_N : {0.4, 0.8, 1.5}) {
    for (const double wall_N_m : {300.0, 600.0, 1200.0}) {
      SCOPED_TRACE(testing::Message() << base_N << " N, " << wall_N_m << " N/m");
      Press press{.wall_N_m = wall_N_m, .base_N = base_N};
      press.asked.tip_base_m[2] = press.aim.tip_base_m[2] = -0.05;
      press.Hold(3, true);
      EXPECT_LT(press.deepest_m, base_N / wall_N_m + 6e-3);
      EXPECT_GT(press.force_N, 0.65 * base_N);
      press.base_N *= 0.7;  // the coils are warm
      press.deepest_m = 0;
      press.Hold(3, true);
      EXPECT_LT(press.deepest_m, base_N / wall_N_m + 6e-3);
      EXPECT_GT(press.force_N, 0.65 * press.base_N);
    }
  }
}

TEST(AimLimit, WithoutItTheHandIsPushedThrough) {
  Press press;
  press.asked.tip_base_m[2] = press.aim.tip_base_m[2] = -0.05;
  press.Hold(3, false);
  EXPECT_GT(press.deepest_m, 0.03);
}

// A soft body asks for less than the base can make, however deep the pen is in it.
TEST(AimLimit, SoftBodyIsNotPushedThrough) {
  for (const double wall_N_m : {60.0, 90.0, 150.0}) {
    SCOPED_TRACE(testing::Message() << wall_N_m << " N/m");
    Press press{.wall_N_m = wall_N_m, .base_N = 2};
    press.asked.tip_base_m[2] = press.aim.tip_base_m[2] = -0.05;
    press.Hold(3, true);
    EXPECT_LT(press.deepest_m, 0.009);
    EXPECT_GT(press.force_N, 0.005 * wall_N_m);
  }
}

TEST(AimLimit, HandThatTheBaseCanHoldIsFree) {
  Press press;
  press.asked.tip_base_m[2] = press.aim.tip_base_m[2] = -0.004;  // 0.48 N
  press.Hold(2, true);
  EXPECT_EQ(press.aim.tip_base_m[2], -0.004);
  press.asked.tip_base_m[2] = 0.03;
  press.Hold(1, true);
  EXPECT_EQ(press.aim.tip_base_m[2], 0.03);
  EXPECT_FALSE(std::isfinite(press.limit.beyond_m()));
}

TEST(AimLimit, AxisAndPresenceStay) {
  Press press;
  press.asked.present = 0;
  press.asked.axis_base = {0, 1, 0};
  press.asked.tip_base_m[2] = press.aim.tip_base_m[2] = -0.05;
  press.Hold(1, true);
  EXPECT_EQ(press.aim.present, 0U);
  EXPECT_EQ(press.aim.axis_base, (std::array<double, 3>{0, 1, 0}));
}

}  // namespace
}  // namespace omni::monitor
