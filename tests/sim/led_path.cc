// A guided hand: goes to its aim smoothly, and stays there without a new one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "service/sim/hand/hand.h"
#include "service/sim/twin/twin.h"
#include "tests/support/rig/twin_scenario.h"

namespace omni::sim {
namespace test_sim_led_path {

constexpr double kStep_s = 250e-6;
constexpr double kTipOffset_m = 0.005;

LedPath At(const Vec3& tip_m) {
  return LedPath({.centre_base_m = tip_m - kTipOffset_m * Vec3{0, 0, -1}, .axis_base = {0, 0, -1}}, kTipOffset_m);
}

Vec3 TipOf(const HandTarget& target) { return target.centre_base_m + kTipOffset_m * target.axis_base; }

TEST(LedPath, ReachesItsAimWithoutOvershoot) {
  for (const double way_m : {0.0005, 0.01, 0.1, 0.5}) {
    LedPath path = At({0, 0, 0.06});
    path.SetAim({.tip_base_m = {way_m, 0, 0.06}});
    Vec3 last_m_s;
    for (int i = 0; i < 12000; ++i) {
      path.Step(kStep_s);
      const HandTarget target = path.Target();
      EXPECT_LE(TipOf(target).x, way_m + 1e-9);
      EXPECT_LE(Norm(target.velocity_base_m_s), 0.5 + 1e-9);
      EXPECT_LE(Norm(target.velocity_base_m_s - last_m_s) / kStep_s, 20 + 1e-6);
      last_m_s = target.velocity_base_m_s;
    }
    EXPECT_NEAR(TipOf(path.Target()).x, way_m, 1e-6) << way_m;
  }
}

TEST(LedPath, VelocityIsTheDerivativeOfPosition) {
  LedPath path = At({0, 0, 0.06});
  path.SetAim({.tip_base_m = {0.03, -0.02, 0.05}, .axis_base = Normalized(Vec3{0.4, 0.1, -1})});
  Vec3 before = path.Target().centre_base_m;
  for (int i = 0; i < 2000; ++i) {
    path.Step(kStep_s);
    const HandTarget target = path.Target();
    const Vec3 slope = (1 / kStep_s) * (target.centre_base_m - before);
    EXPECT_LT(Norm(slope - target.velocity_base_m_s), 2e-5 + 1e-3 * Norm(slope)) << i;
    EXPECT_NEAR(Norm(target.axis_base), 1, 1e-12);
    before = target.centre_base_m;
  }
  EXPECT_LT(Norm(path.Target().axis_base - Normalized(Vec3{0.4, 0.1, -1})), 1e-6);
}

TEST(LedPath, HoldsItsPositionWithoutANewAim) {
  LedPath path = At({0, 0, 0.06});
  path.SetAim({.tip_base_m = {0.01, 0, 0.055}});
  for (int i = 0; i < 4000; ++i) path.Step(kStep_s);
  for (int i = 0; i < 40000; ++i) {
    path.Step(kStep_s);
    EXPECT_LT(Norm(TipOf(path.Target()) - Vec3{0.01, 0, 0.055}), 1e-6);
  }
}

// Taken away and brought again: it comes from above, wherever it was aimed at meanwhile, and arrives.
TEST(LedPath, ReturningPenComesDownFromAbove) {
  LedPath path = At({0.02, 0, 0.06});
  path.SetAim({.tip_base_m = {0, 0, 0}, .present = false});
  for (int i = 0; i < 2000; ++i) path.Step(1e-3);
  const Vec3 aim{0.01, -0.01, 0.07};
  path.SetAim({.tip_base_m = aim});
  double lowest_m = 1;
  for (int i = 0; i < 2000; ++i) {
    const HandTarget target = path.Target();
    EXPECT_TRUE(target.present);
    lowest_m = std::min(lowest_m, (target.centre_base_m + kTipOffset_m * target.axis_base).z);
    path.Step(1e-3);
  }
  EXPECT_NEAR(lowest_m, aim.z, 1e-6) << "never lower than where it is wanted";
  const HandTarget there = path.Target();
  EXPECT_LT(Norm(there.centre_base_m + kTipOffset_m * there.axis_base - aim), 1e-5);
}

TEST(LedPath, OppositeAxesTurnThroughAPerpendicular) {
  LedPath path = At({0, 0, 0.09});
  path.SetAim({.tip_base_m = {0, 0, 0.09}, .axis_base = {0, 0, 1}});
  for (int i = 0; i < 8000; ++i) {
    path.Step(kStep_s);
    ASSERT_NEAR(Norm(path.Target().axis_base), 1, 1e-12);
  }
  EXPECT_NEAR(path.Target().axis_base.z, 1, 1e-6);
}

HandScript Tour() {
  HandScript script = support::Holding({0, 0, 0.06});
  script.waypoints.push_back({1.0, {0.02, 0, 0.05}, {0, 0, -1}, true});
  script.tremor_m = 1e-4;
  return script;
}

TEST(LedHand, IgnoresWaypointsAfterTheFirst) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(1);
  Hand hand(Tour(), device, random, true);
  for (int i = 0; i < 12000; ++i) hand.Step(i * kStep_s, kStep_s, {});
  const Vec3 tip = hand.pose().centre_base_m + device.magnet.tip_offset_m * hand.pose().axis_base;
  EXPECT_LT(Norm(tip - Vec3{0, 0, 0.06}), 5e-4) << "but for its tremor";
}

TEST(LedHand, KeepsItsStiffnessAndTremor) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(2);
  Hand hand(Tour(), device, random, true);
  hand.SetAim({.tip_base_m = {0.01, 0, 0.06}});
  const Vec3 force{0, 0, 0.6};
  double least_m = 1, most_m = -1;
  for (int i = 0; i < 16000; ++i) {
    hand.Step(i * kStep_s, kStep_s, force);
    if (i < 8000) continue;
    least_m = std::min(least_m, hand.pose().centre_base_m.z);
    most_m = std::max(most_m, hand.pose().centre_base_m.z);
  }
  EXPECT_NEAR(0.5 * (least_m + most_m), 0.06 + device.magnet.tip_offset_m + 0.6 / 150, 1e-4) << "yields by F / k";
  EXPECT_GT(most_m - least_m, 1e-4) << "trembles";
}

TEST(LedHand, NeverEntersTheHullForAnyAim) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(3);
  Hand hand(Tour(), device, random, true);
  for (int i = 0; i < 40000; ++i) {
    if (i % 400 == 0)
      hand.SetAim({.tip_base_m = random.NormalVector(0.03), .axis_base = Normalized(random.NormalVector(1))});
    hand.Step(i * kStep_s, kStep_s, random.NormalVector(2));
    ASSERT_GE(hand.gap_m(), 0) << i;
    ASSERT_TRUE(std::isfinite(Norm(hand.velocity_base_m_s()))) << i;
  }
}

TEST(LedHand, TakesThePenAwayAndBringsItBack) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(4);
  Hand hand(Tour(), device, random, true);
  EXPECT_TRUE(hand.present());
  hand.SetAim({.tip_base_m = {0, 0, 0.2}, .present = false});
  hand.Step(0, kStep_s, {});
  EXPECT_FALSE(hand.present());
  hand.SetAim({.tip_base_m = {0, 0, 0.06}});
  hand.Step(kStep_s, kStep_s, {});
  EXPECT_TRUE(hand.present());
}

// Aims that come every tick in virtual time.
class Circle final : public HandGuide {
 public:
  bool Poll(HandAim& aim) noexcept override {
    const double angle = 0.003 * ++calls_;
    if (calls_ % 7 != 0) return false;
    aim = {.tip_base_m = {0.01 * std::cos(angle), 0.01 * std::sin(angle), 0.055}};
    return true;
  }
  int calls_ = 0;
};

TEST(LedTwin, EqualAimsGiveBitIdenticalScans) {
  std::optional<base::HallScan> last;
  for (int run = 0; run < 2; ++run) {
    TwinOptions options = support::HoldingTwin({0, 0, 0.06});
    options.seed = 7;
    options.guide = std::make_shared<Circle>();
    const auto twin = MakeVirtualTwin(support::NominalDevice(), options, 1.5);
    base::HallScan scan;
    while (twin->Read(scan, 0) == device::ReadStatus::kScan) twin->Write({{0, 0, 1}});
    if (last) {
      EXPECT_EQ(last->field_sensor_T, scan.field_sensor_T);
    }
    last = scan;
  }
}

}  // namespace test_sim_led_path
}  // namespace omni::sim
