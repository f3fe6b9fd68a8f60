// An application's own forces and constraints through the whole loop against the twin, in virtual time.
#include <gtest/gtest.h>

#include <cmath>

#include "service/actuation/actuation.h"
#include "service/base/limits.h"
#include "service/haptics/scene/scene.h"
#include "service/magnetics/nominal.h"
#include "service/sim/fields/random.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_loop_force {

// Still above the base, in the air.
sim::HandScript HoldStill() {
  sim::HandScript script;
  script.name = "hold";
  script.waypoints = {{.duration_s = 0, .tip_base_m = {0, 0, 0.055}}};
  return script;
}

// Commands of an owner that pushes: `Scenario::Open` plus this.
struct PushScenario {
  explicit PushScenario(double seconds, const sim::HandScript& script = HoldStill()) : scenario(script, seconds) {}

  bool Step() {
    return scenario.Step(nothing, [this](const base::HallScan& scan) {
      loop::Commands commands = Scenario::Open(scan);
      commands.applied = applied;
      now_ns = scan.t_ns;
      return commands;
    });
  }
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) ASSERT_TRUE(Step());
  }
  void Push(const base::Vec3& force_N, int ms, double ramp_s = 0) {
    applied.open = true;
    ++applied.force_id;
    applied.force_base_N = force_N;
    applied.force_end_ns = now_ns + ms * 1'000'000LL;
    applied.ramp_s = ramp_s;
  }
  void Set(const haptics::Constraint& constraint) {
    applied.open = true;
    ++applied.constraints_id;
    applied.constraints_t_ns = now_ns;
    applied.constraint_count = 1;
    applied.constraints[0] = constraint;
  }

  const haptics::Scene nothing;
  Scenario scenario;
  haptics::AppliedCommand applied;
  std::int64_t now_ns = 0;
};

TEST(LoopForce, AppliedForceReachesTheCoilsAndEnds) {
  PushScenario push(1.5);
  push.Run(600);  // found, gate open
  ASSERT_EQ(push.scenario.current_A(), 0);
  push.Push({0.3, -0.2, 0.4}, 80);
  push.Run(40);
  const base::Vec3& f = push.scenario.output.wrench.force_N;
  EXPECT_NEAR(f.x, 0.3, 1e-9);
  EXPECT_NEAR(f.y, -0.2, 1e-9);
  EXPECT_NEAR(f.z, 0.4, 1e-9);
  EXPECT_GT(push.scenario.current_A(), 0.1);
  EXPECT_FALSE(push.scenario.output.saturated);
  push.Run(40);
  int ms = 0;
  for (; ms < 60 && push.scenario.current_A() != 0; ++ms) ASSERT_TRUE(push.Step());
  EXPECT_LE(ms, 25) << "after the deadman's end";
}

TEST(LoopForce, ExcessiveForceIsScaledAlongItsDirection) {
  PushScenario push(1.5);
  push.Run(600);
  push.Push({30, 0, 40}, 80);
  push.Run(40);
  const base::Vec3& f = push.scenario.output.wrench.force_N;
  EXPECT_TRUE(push.scenario.output.saturated);
  EXPECT_LE(push.scenario.force_N(), 2.0 + 1e-9);
  EXPECT_GT(push.scenario.force_N(), 0.1);
  EXPECT_NEAR(f.x / push.scenario.force_N(), 0.6, 1e-6);
  EXPECT_NEAR(f.z / push.scenario.force_N(), 0.8, 1e-6);
}

// What the currents make at the tick's pose, core's pull included, against the request: `saturated` exactly when less
// is made, and what is published is made. From 0.5 N on, where all of the pull is compensated.
TEST(LoopForce, SaturatedExactlyWhenLessIsMadeThanRequested) {
  constexpr double kAgree = 0.005;
  sim::Random random(77);
  base::Calibration exact = magnetics::NominalCalibration(config::DefaultDevice());
  exact.expected_error_m = 5e-5;
  int whole = 0, cut = 0;
  for (const base::Vec3& tip : {base::Vec3{0, 0, 0.042}, base::Vec3{0.02, 0, 0.042}, base::Vec3{0, -0.03, 0.037},
                                base::Vec3{0.02, 0.025, 0.04}, base::Vec3{0, 0, 0.058}}) {
    sim::HandScript script;
    script.name = "hold";
    script.waypoints = {{.duration_s = 0, .tip_base_m = tip}};
    PushScenario push(4.5, script);
    push.scenario.config = loop::MakeTickConfig(config::DefaultDevice(), exact);
    push.Run(600);
    for (int trial = 0; trial < 40; ++trial) {
      const base::Vec3 direction = Normalized(random.NormalVector(1));
      const double request_N = random.Uniform(0.55, 2.6);
      push.Push(request_N * direction, 100);
      push.Run(50);
      const loop::TickOutput& output = push.scenario.output;
      if (output.tool.status != base::TrackingStatus::kTracking || output.near_singular) continue;
      const base::Vec3 made_N =
          actuation::ForceFromCurrents(push.scenario.config.actuation.map, output.tool, output.currents.current_A);
      const base::Vec3& published_N = output.wrench.force_N;
      if (Norm(published_N) < 0.5) continue;
      EXPECT_LE(Norm(made_N - published_N), kAgree * Norm(published_N)) << "at " << tip.z << ", " << trial;
      const bool less = Dot(made_N, direction) < (1 - kAgree) * request_N;
      EXPECT_EQ(output.saturated, less) << request_N << " requested, " << Norm(made_N) << " made";
      (less ? cut : whole) += 1;
    }
  }
  EXPECT_GT(whole, 40);
  EXPECT_GT(cut, 40);
}

TEST(LoopForce, StuckControlThreadEndsTheForce) {
  PushScenario push(1.5);
  push.Run(600);
  push.Set(
      {.kind = haptics::ConstraintKind::kPoint, .stiffness_N_m = 100, .max_force_N = 1, .point_base_m = {0, 0, 0.060}});
  push.Run(300);
  ASSERT_GT(push.scenario.force_N(), 0.1);
  int ms = 0;
  const std::int64_t written_ns = push.now_ns;
  for (; ms < 100 && push.scenario.current_A() != 0; ++ms) {
    ASSERT_TRUE(push.scenario.Step(push.nothing, [&](const base::HallScan& scan) {
      loop::Commands commands = Scenario::Open(scan);
      commands.applied = push.applied;
      commands.t_ns = written_ns;
      return commands;
    }));
  }
  EXPECT_LE(ms, 55);
}

TEST(LoopForce, DeviceFaultEndsTheForce) {
  PushScenario push(1.5);
  push.Run(600);
  push.Push({0.5, 0, 0}, 100);
  push.Run(30);
  ASSERT_GT(push.scenario.current_A(), 0.1);
  base::HallScan scan = push.scenario.scan;
  for (int i = 0; i < 20; ++i) {
    scan.t_ns += base::kTickPeriod_ns;
    scan.device_faults = 1;
    loop::Commands commands = Scenario::Open(scan);
    commands.applied = push.applied;
    loop::Tick(push.scenario.config, scan, commands, push.nothing, push.scenario.state, push.scenario.output);
  }
  EXPECT_EQ(push.scenario.current_A(), 0);
  EXPECT_FALSE(push.scenario.output.applied.acts);
}

// The twin's hand holds the pen by a spring: a constraint pulls it towards its point, and it does not oscillate there.
TEST(LoopForce, ConstraintPullsTheHandWithoutOscillation) {
  PushScenario push(4.0);
  push.Run(800);
  const base::Vec3 rest = push.scenario.output.tool.device_point_base_m;
  push.Set({.kind = haptics::ConstraintKind::kPoint,
            .stiffness_N_m = 5000,
            .damping_Ns_m = 1,
            .max_force_N = 1.5,
            .point_base_m = {rest.x, rest.y, rest.z + 0.004}});
  push.Run(2000);
  double highest = -1, lowest = 1;
  for (int i = 0; i < 500; ++i) {
    push.Run(1);
    highest = std::max(highest, push.scenario.output.tool.device_point_base_m.z);
    lowest = std::min(lowest, push.scenario.output.tool.device_point_base_m.z);
  }
  EXPECT_GT(0.5 * (highest + lowest), rest.z + 0.0003) << "it was pulled upwards";
  EXPECT_LT(highest - lowest, 0.001) << "and does not oscillate";
  EXPECT_TRUE(push.scenario.output.applied.stiffness_limited) << "5000 N/m are not possible";
  EXPECT_EQ(push.scenario.output.applied.energy_gain, 1);
}

TEST(LoopForce, NoCurrentWithoutAForceRequest) {
  PushScenario push(1.0);
  push.applied.open = true;
  for (int i = 0; i < 900; ++i) {
    push.Run(1);
    ASSERT_EQ(push.scenario.current_A(), 0);
  }
}

}  // namespace test_loop_force
}  // namespace omni::test
