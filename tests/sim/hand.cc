// The hand: follows its script, yields by F / k, never enters the hull. And its script files.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "service/sim/hand/hand.h"
#include "service/sim/twin/twin.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/twin_scenario.h"

namespace omni::sim {
namespace test_sim_hand {

constexpr double kStep_s = 250e-6;

HandScript Tour() {
  HandScript script;
  script.waypoints = {{1.0, {0, 0, 0.05}, {0, 0, -1}, true},
                      {0.5, {0.04, 0, 0.05}, {0, 0.5, -std::sqrt(0.75)}, true},
                      {0.8, {0, 0.04, 0.06}, {0, 0, -1}, true}};
  return script;
}

TEST(SimHand, FollowsItsPathWithoutForces) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(1);
  const HandScript script = Tour();
  const HandPath path(script, device.magnet.tip_offset_m, random);
  Hand hand(script, device, random);
  double worst_m = 0;
  for (int i = 0; i < 8000; ++i) {
    hand.Step(i * kStep_s, kStep_s, {});
    worst_m = std::max(worst_m, Norm(hand.pose().centre_base_m - path.TargetAt((i + 1) * kStep_s).centre_base_m));
  }
  EXPECT_LT(worst_m, 2e-3);
  EXPECT_NEAR(script.duration_s(), 1.3, 1e-12);
  const Vec3 tip = hand.pose().centre_base_m + device.magnet.tip_offset_m * hand.pose().axis_base;
  EXPECT_LT(Norm(tip - Vec3{0, 0.04, 0.06}), 1e-4) << "rests at the last waypoint";
}

TEST(SimHand, PathVelocityIsTheDerivativeOfPosition) {
  Random random(2);
  HandScript script = Tour();
  script.tremor_m = 1e-3;
  script.repeat = true;
  const HandPath path(script, 0.005, random);
  for (int step = 0; step < 126; ++step) {
    const double t = 0.013 + 0.0317 * step;
    const double h = 1e-6;
    const Vec3 slope = (1 / (2 * h)) * (path.TargetAt(t + h).centre_base_m - path.TargetAt(t - h).centre_base_m);
    EXPECT_LT(Norm(slope - path.TargetAt(t).velocity_base_m_s), 1e-5 + 1e-4 * Norm(slope)) << t;
    EXPECT_NEAR(Norm(path.TargetAt(t).axis_base), 1, 1e-12);
  }
}

TEST(SimHand, RepeatingPathClosesSmoothly) {
  Random random(3);
  HandScript script = Tour();
  script.repeat = true;
  const HandPath path(script, 0.005, random);
  EXPECT_LT(Norm(path.TargetAt(0).centre_base_m - path.TargetAt(2.3).centre_base_m), 1e-9);
  EXPECT_LT(Norm(path.TargetAt(0.7).centre_base_m - path.TargetAt(0.7 + 2 * 2.3).centre_base_m), 1e-9);
  EXPECT_LT(Norm(path.TargetAt(2.3 - 1e-6).centre_base_m - path.TargetAt(2.3).centre_base_m), 1e-6);
}

TEST(SimHand, TremorHasTheConfiguredRms) {
  Random random(4);
  HandScript script = support::Holding({0, 0, 0.06});
  script.tremor_m = 1e-3;
  const HandPath path(script, 0.005, random);
  double sum = 0;
  const int count = 40000;
  for (int i = 0; i < count; ++i) {
    const Vec3 off = path.TargetAt(i * 1e-3).centre_base_m - Vec3{0, 0, 0.065};
    sum += Dot(off, off);
  }
  EXPECT_NEAR(std::sqrt(sum / count), 1e-3, 5e-5);
}

TEST(SimHand, YieldsByForceOverStiffness) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(5);
  Hand hand(support::Holding({0, 0, 0.06}), device, random);
  const Vec3 rest = hand.pose().centre_base_m;
  const Vec3 force{0.6, -0.3, 0.9};
  for (int i = 0; i < 8000; ++i) hand.Step(i * kStep_s, kStep_s, force);
  EXPECT_LT(Norm(hand.pose().centre_base_m - rest - (1.0 / 150) * force), 1e-6);
}

TEST(SimHand, NoWaypointsMeansNoPen) {
  Random random(8);
  const Hand hand(HandScript{}, support::NominalDevice(), random);
  EXPECT_FALSE(hand.present());
}

TEST(SimHand, OppositeAxesTurnThroughAPerpendicular) {
  Random random(6);
  HandScript script;
  script.waypoints = {{0, {0, 0, 0.08}, {0, 0, -1}, true}, {1, {0, 0, 0.08}, {0, 0, 1}, true}};
  const HandPath path(script, 0.005, random);
  EXPECT_NEAR(path.TargetAt(0.5).axis_base.z, 0, 1e-9);
  EXPECT_NEAR(path.TargetAt(1).axis_base.z, 1, 1e-9);
}

// Pushed at the base from everywhere, with every tilt: the disc stays outside, whatever the forces.
TEST(SimHand, NeverEntersTheHull) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(7);
  HandScript script;
  script.repeat = true;
  script.stiffness_N_m = 1000;
  for (int i = 0; i < 40; ++i) {
    const Vec3 axis = Normalized(random.NormalVector(1) + Vec3{0, 0, 1e-3});
    script.waypoints.push_back({0.05 * (i % 4), random.NormalVector(0.03), axis, i % 7 != 0});
  }
  ASSERT_EQ(CheckHandScript(script), "");
  Hand hand(script, device, random);
  for (int i = 0; i < 20000; ++i) {
    hand.Step(i * kStep_s, kStep_s, random.NormalVector(5));
    ASSERT_GE(hand.gap_m(), 0) << i;
    ASSERT_TRUE(std::isfinite(Norm(hand.velocity_base_m_s()))) << i;
    const MagnetPose predicted = hand.PredictedPose((i + 1) * kStep_s + 0.5e-3);
    ASSERT_GE(GapToHull(device.magnet, device.hull_radius_m, predicted).gap_m, -1e-9) << i;
  }
}

TEST(SimHand, TwinPenSettlesWhereMagneticForceAndHandBalance) {
  const test::TempFolder folder;
  TwinOptions options = support::HoldingTwin({0, 0, 0.045});
  options.recording_path = folder.Path("truth.csv");
  {
    const auto twin = MakeVirtualTwin(support::NominalDevice(), options, 2.1);
    for (base::HallScan scan; twin->Read(scan, 0) == device::ReadStatus::kScan;) twin->Write({{0, 0, 2}});
  }
  const support::Table table = support::ReadTable(options.recording_path);
  const std::size_t last = table.rows.size() - 1;
  EXPECT_GT(table.At(last, "coil_force_z_N"), 0.1) << "opposed moments repel";
  const auto vector = [&](const std::string& name, const std::string& unit) {
    return Vec3{table.At(last, name + "_x" + unit), table.At(last, name + "_y" + unit),
                table.At(last, name + "_z" + unit)};
  };
  EXPECT_LT(Norm(vector("magnet", "_m") - Vec3{0, 0, 0.050} - (1.0 / 150) * vector("force", "_N")), 1e-5);
}

struct BadScript {
  std::string text;
  std::string expected;  // part of the message
};

TEST(SimScript, BadFilesAreReportedWithTheirJsonPointer) {
  const test::TempFolder folder;
  const std::string path = folder.Path("hand.json");
  const std::vector<BadScript> cases{
      {"", "not valid JSON"},
      {"{\"waypoints\": [", "not valid JSON"},
      {"[]", "/: an object is expected"},
      {"{}", "/waypoints: at least one"},
      {R"({"waypoints": []})", "/waypoints: at least one"},
      {R"({"waypoints": 3})", "/waypoints: an array is expected"},
      {R"({"waypoints": [{"s": 1}]})", "/waypoints/0: tip_m"},
      {R"({"waypoints": [{"tip_m": [0, 0]}]})", "/waypoints/0/tip_m: an array of three"},
      {R"({"waypoints": [{"tip_m": [0, 0, "a"]}]})", "/waypoints/0/tip_m/2: a number"},
      {R"({"waypoints": [{"tip_m": [0, 0, NaN]}]})", "not valid JSON"},
      {R"({"waypoints": [{"tip_m": [0, 0, 1e400]}]})", "not valid JSON"},
      {R"({"waypoints": [{"tip_m": [0, 0, 1e300]}]})", "/waypoints/0/tip_m/2: 1e+300"},
      {R"({"waypoints": [{"tip_m": [0, 0, 0.1], "axis": [0, 0, 0]}]})", "/waypoints/0/axis"},
      {R"({"waypoints": [{"tip_m": [0, 0, 0.1]}, {"tip_m": [0, 0, 0.1], "s": -1}]})", "/waypoints/1/s: -1"},
      {R"({"waypoints": [{"tip_m": [0, 0, 0.1], "present": 1}]})", "/waypoints/0/present: true or false"},
      {R"({"waypoints": [{"tip_m": [0, 0, 0.1], "speed": 1}]})", "/waypoints/0/speed: unknown key"},
      {R"({"hand": {"mass_kg": 0}, "waypoints": [{"tip_m": [0, 0, 0.1]}]})", "/hand/mass_kg: 0 is not within"},
      {R"({"hand": {"stiffness_N_m": 1e6}, "waypoints": [{"tip_m": [0, 0, 0.1]}]})", "/hand/stiffness_N_m"},
      {R"({"hand": {"mas": 1}, "waypoints": [{"tip_m": [0, 0, 0.1]}]})", "/hand/mas: unknown key"},
      {R"({"name": 3, "waypoints": [{"tip_m": [0, 0, 0.1]}]})", "/name: a text"},
      {R"({"repeat": true, "waypoints": [{"tip_m": [0, 0, 0.1]}, {"tip_m": [0, 0, 0.2]}]})", "/repeat"}};
  for (const BadScript& bad : cases) {
    std::ofstream(path, std::ios::trunc) << bad.text;
    const auto script = LoadHandScript(path);
    ASSERT_FALSE(script.ok()) << bad.text;
    EXPECT_NE(script.error().find(path), std::string::npos) << script.error();
    EXPECT_NE(script.error().find(bad.expected), std::string::npos) << script.error();
  }
  EXPECT_FALSE(LoadHandScript(folder.Path("missing.json")).ok());
  EXPECT_FALSE(LoadHandScript("/").ok());
}

TEST(SimScript, TooManyWaypointsAreRefused) {
  const test::TempFolder folder;
  const std::string path = folder.Path("hand.json");
  {
    std::ofstream file(path);
    file << R"({"waypoints": [{"tip_m": [0, 0, 0.1]})";
    for (int i = 0; i < 10000; ++i) file << R"(,{"s": 1, "tip_m": [0, 0, 0.1]})";
    file << "]}";
  }
  const auto script = LoadHandScript(path);
  ASSERT_FALSE(script.ok());
  EXPECT_NE(script.error().find("10001 waypoints, the limit is 10000"), std::string::npos) << script.error();
}

TEST(SimScript, GoodFileIsReadAndItsAxisNormalised) {
  const test::TempFolder folder;
  const std::string path = folder.Path("hand.json");
  std::ofstream(path) << R"({"name": "n", "repeat": true, "hand": {"stiffness_N_m": 200, "tremor_m": 0.0005},
    "waypoints": [{"s": 1, "tip_m": [0, 0, 0.05]},
                  {"s": 2.5, "tip_m": [0.01, 0, 0.05], "axis": [0, 0, -3], "present": false}]})";
  const auto script = LoadHandScript(path);
  ASSERT_TRUE(script.ok()) << script.error();
  EXPECT_EQ(script->name, "n");
  EXPECT_TRUE(script->repeat);
  EXPECT_EQ(script->stiffness_N_m, 200);
  EXPECT_EQ(script->mass_kg, 0.12);
  EXPECT_EQ(script->tremor_m, 0.0005);
  ASSERT_EQ(script->waypoints.size(), 2U);
  EXPECT_NEAR(script->waypoints[1].axis_base.z, -1, 1e-15);
  EXPECT_FALSE(script->waypoints[1].present);
  EXPECT_EQ(script->duration_s(), 2.5);
}

}  // namespace test_sim_hand
}  // namespace omni::sim
