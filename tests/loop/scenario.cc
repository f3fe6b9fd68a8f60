// Scenarios of the whole loop against the twin in virtual time.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "service/base/limits.h"
#include "service/haptics/scene/scene.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_loop_scenario {

constexpr double kSlewTolerance = 1.05;

TEST(LoopScenario, PenIsTrackedAndPushedBackByATable) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(PressAndSlide(), 4.0);
  int contact = 0;
  int tracked = 0;
  int ticks = 0;
  double peak_N = 0;
  double up_N = 0;
  while (scenario.Step(table)) {
    ++ticks;
    tracked += scenario.output.tool.status == base::TrackingStatus::kTracking ? 1 : 0;
    contact += scenario.force_N() > 0.01 ? 1 : 0;
    peak_N = std::max(peak_N, scenario.force_N());
    if (scenario.force_N() > 0.1) up_N += scenario.output.wrench.force_N.z;
  }
  EXPECT_EQ(ticks, 4000);
  EXPECT_GT(tracked, 3980);
  EXPECT_GT(contact, 1000);
  EXPECT_GT(peak_N, 0.3);
  EXPECT_LE(peak_N, 2.0 + 1e-9);
  EXPECT_GT(up_N, 0);
  const auto& select = scenario.output.inputs.components[static_cast<std::size_t>(base::InputComponent::kSelect)];
  EXPECT_GE(select.press_count, 1U);
  EXPECT_EQ(select.press_count, select.release_count);
}

// A hand holds the pen still, first above the table and then on it. Only in the air may it be classified as at rest.
TEST(LoopScenario, PenInContactIsNotClassifiedAsAtRest) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(PressAndSlide(), 2.3);
  const auto at_rest = [&] { return scenario.state.tracker.pose.filter.motions.likely[tracker::kAtRest]; };
  double in_air = 0, in_touch = 0;
  while (scenario.Step(table)) {
    const bool in_touch_long = scenario.state.tick > 1900 && scenario.force_N() > 0.1;
    if (in_touch_long) in_touch = std::max(in_touch, at_rest());
    if (scenario.force_N() == 0) in_air = std::max(in_air, at_rest());
  }
  EXPECT_GT(in_air, 0.5);
  EXPECT_LT(in_touch, 1e-3);
}

TEST(LoopScenario, NoCurrentWithoutAnOwner) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(PressAndSlide(), 2.5);
  const auto closed = [](const base::HallScan& scan) {
    loop::Commands commands = Scenario::Open(scan);
    commands.gate = loop::ForceGate::kClosed;
    return commands;
  };
  while (scenario.Step(table, closed)) ASSERT_EQ(scenario.current_A(), 0);
}

TEST(LoopScenario, NoCurrentWithoutAScene) {
  const haptics::Scene nothing;
  Scenario scenario(PressAndSlide(), 2.5);
  while (scenario.Step(nothing)) ASSERT_EQ(scenario.current_A(), 0);
}

// Runs into the hold phase with the gate open, then lets `commands` rule; returns ms until the currents are zero.
double MillisecondsToZero(
    const std::function<loop::Commands(const base::HallScan&)>& after,
    const std::function<void(Scenario&)>& change = [](Scenario&) {}) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(PressAndSlide(), 2.3);
  while (scenario.scan.sequence == 0 || scenario.state.tick < 1900) {
    if (!scenario.Step(table)) return -1;
  }
  if (!(scenario.current_A() > 0.5)) return -2;  // it must be pushing
  change(scenario);
  for (int ms = 0; scenario.Step(table, after); ++ms) {
    if (scenario.current_A() == 0) return ms;
  }
  return -3;
}

TEST(LoopScenario, ForceIsZeroWithin20MillisecondsOfOwnerLoss) {
  const double ms = MillisecondsToZero([](const base::HallScan& scan) {
    return loop::Commands{.t_ns = scan.t_ns, .gate = loop::ForceGate::kClosed, .scene_generation = 1};
  });
  EXPECT_GE(ms, 2);  // a ramp, not a step
  EXPECT_LE(ms, 20);
}

TEST(LoopScenario, ForceOfSilentOwnerFadesOver100Milliseconds) {
  const double ms = MillisecondsToZero(Scenario::Open, [](Scenario& scenario) {
    scenario.feeds.owner_silence_ns = scenario.config.silent_after_ns + 1;
  });
  EXPECT_GE(ms, 60);
  EXPECT_LE(ms, 110);
}

TEST(LoopScenario, ForceDoesNotFadeForSlowOwner) {
  const double ms = MillisecondsToZero(
      Scenario::Open, [](Scenario& scenario) { scenario.feeds.owner_silence_ns = scenario.config.silent_after_ns; });
  EXPECT_EQ(ms, -3);
}

// The control thread comes back after 220 ms; the owner has hung meanwhile, or its next sign of life comes later.
TEST(LoopScenario, AfterStuckControlThreadForceReturnsWithNextSignOfLifeOnly) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(PressAndSlide(), 2.9);
  while (scenario.state.tick < 1900 && scenario.Step(table)) {
  }
  ASSERT_GT(scenario.current_A(), 0.5);
  const std::int64_t written_ns = scenario.scan.t_ns, back_ns = written_ns + 220'000'000;
  std::int64_t beat_ns = written_ns + 200'000'000;
  const auto commands = [&](const base::HallScan& scan) {
    loop::Commands now = Scenario::Open(scan);
    if (scan.t_ns < back_ns) now.t_ns = written_ns;
    scenario.feeds.owner_silence_ns = scan.t_ns < beat_ns ? 0 : scan.t_ns - beat_ns;
    return now;
  };
  const auto step_until = [&](std::int64_t end_ns) {
    double peak_A = 0;
    while (scenario.scan.t_ns < end_ns && scenario.Step(table, commands)) {
      if (scenario.scan.t_ns > back_ns) peak_A = std::max(peak_A, scenario.current_A());
    }
    return peak_A;
  };
  EXPECT_EQ(step_until(back_ns + 100'000'000), 0) << "its last sign of life is 20 ms older than the commands";
  beat_ns = std::numeric_limits<std::int64_t>::max();
  EXPECT_GT(step_until(back_ns + 300'000'000), 0.5);
}

TEST(LoopScenario, ForceFadesIfTheControlThreadIsStuck) {
  std::int64_t written_ns = 0;
  const double ms = MillisecondsToZero([&](const base::HallScan& scan) {
    if (written_ns == 0) written_ns = scan.t_ns;
    loop::Commands commands = Scenario::Open(scan);
    commands.t_ns = written_ns;
    return commands;
  });
  EXPECT_GE(ms, 150);  // 100 ms of patience and the fade
  EXPECT_LE(ms, 220);
}

TEST(LoopScenario, DeviceFaultZeroesTheCurrent) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(PressAndSlide(), 2.3);
  while (scenario.state.tick < 1900 && scenario.Step(table)) {
  }
  ASSERT_GT(scenario.current_A(), 0.5);
  base::HallScan scan = scenario.scan;
  for (int i = 0; i < 20; ++i) {
    scan.t_ns += base::kTickPeriod_ns;
    scan.device_faults = 1;
    loop::Tick(scenario.config, scan, Scenario::Open(scan), table, scenario.state, scenario.output);
  }
  EXPECT_EQ(scenario.current_A(), 0);
  EXPECT_TRUE(scenario.output.faults & loop::kFaultDevice);
}

TEST(LoopScenario, SceneSwapRampsThroughZero) {
  const haptics::Scene first = TableScene(kTableTop_m);
  const haptics::Scene second = TableScene(kTableTop_m - 0.002);
  Scenario scenario(PressAndSlide(), 2.3);
  while (scenario.state.tick < 1900 && scenario.Step(first)) {
  }
  ASSERT_GT(scenario.force_N(), 0.1);
  const auto swap = [](const base::HallScan& scan) {
    loop::Commands commands = Scenario::Open(scan);
    commands.scene_generation = 2;
    return commands;
  };
  bool asked = false;
  base::Vec3 last = scenario.output.wrench.force_N;
  bool through_zero = false;
  while (scenario.Step(asked ? second : first, swap)) {
    const base::Vec3& f = scenario.output.wrench.force_N;
    const double step_N = Distance(f, last);
    ASSERT_LE(step_N, 0.85 * kSlewTolerance) << scenario.state.tick;
    last = f;
    through_zero = through_zero || scenario.force_N() == 0;
    if (scenario.output.wants_scene && !asked) {
      loop::EnterScene(second, 2, scenario.state);
      asked = true;
    }
  }
  EXPECT_TRUE(asked);
  EXPECT_TRUE(through_zero);
  EXPECT_GT(scenario.force_N(), 0.05);  // the second table is rendered
}

// A pen that is held where a scene puts a body is not pushed out of it, once the pen has been outside it is.
TEST(LoopScenario, BodyThatAppearsAroundTheTipActsOnceTheTipWasOutside) {
  constexpr double kIn_m = kTableTop_m - 0.004, kOut_m = kTableTop_m + 0.01;
  sim::HandScript script = PressAndSlide();
  script.waypoints.clear();
  for (const auto& [duration_s, z_m] :
       {std::pair{0.5, kOut_m}, {0.5, kIn_m}, {1.0, kIn_m}, {0.3, kOut_m}, {0.3, kOut_m}, {0.3, kIn_m}, {1.0, kIn_m}}) {
    script.waypoints.push_back({.duration_s = duration_s, .tip_base_m = {0, 0, z_m}});
  }
  const haptics::Scene nothing, table = TableScene(kTableTop_m);
  Scenario scenario(script, 3.9);
  while (scenario.state.tick < 1500 && scenario.Step(nothing)) {
  }
  loop::EnterScene(table, 1, scenario.state);
  bool was_out = false;
  double inside_N = 0, again_N = 0;
  int said = 0;
  while (scenario.Step(table)) {
    const double z_m = scenario.output.tool.device_point_base_m.z;
    was_out = was_out || z_m > kTableTop_m + 0.002;
    said += !was_out && scenario.output.haptics.waits;
    EXPECT_FALSE(was_out && scenario.output.haptics.waits);
    (was_out ? again_N : inside_N) = std::max(was_out ? again_N : inside_N, scenario.force_N());
  }
  EXPECT_EQ(inside_N, 0);
  EXPECT_GT(said, 100);  // samples have the flag `waits`
  EXPECT_TRUE(was_out);
  EXPECT_GT(again_N, 0.1);
}

// A scene that an application changes while it is touched, and one that comes back with the base or omnid, act at once.
TEST(LoopScenario, OnlyASceneThatAppearsWaitsForTheTip) {
  const haptics::Scene nothing;
  for (const bool touching : {false, true}) {
    for (const std::uint64_t tick : {0U, 499U, 500U, 10'000U}) {
      const auto state = std::make_unique<loop::LoopState>();
      state->tick = tick;
      state->haptics.contacts[0].active = touching;
      loop::EnterScene(nothing, 2, *state);
      EXPECT_EQ(state->haptics.appears, !touching && tick >= 500) << tick;
      EXPECT_EQ(state->scene_generation, 2U);
    }
  }
}

TEST(LoopScenario, AbsentPenGetsNoForceAndIsTrackedAgain) {
  sim::HandScript script = PressAndSlide();
  script.waypoints.insert(script.waypoints.begin() + 4,
                          {.duration_s = 0.5, .tip_base_m = {0, 0, kTableTop_m + 0.01}, .present = false});
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(script, 4.4);
  int absent = 0;
  int tracked_after = 0;
  while (scenario.Step(table)) {
    const bool tracking = scenario.output.tool.status == base::TrackingStatus::kTracking;
    if (scenario.output.tool.status == base::TrackingStatus::kAbsent && scenario.state.tick > 2400) {
      ++absent;
      ASSERT_LT(scenario.force_N(), 1e-12);
    }
    if (absent > 0 && tracking) ++tracked_after;
  }
  EXPECT_GT(absent, 300);
  EXPECT_GT(tracked_after, 500);
}

TEST(LoopScenario, HapticWaveformIsRenderedCountedOnceAndEnds) {
  const haptics::Scene nothing;
  Scenario scenario(PressAndSlide(), 1.0);
  int felt = 0;
  const auto pulse = [](const base::HallScan& scan) {
    loop::Commands commands = Scenario::Open(scan);
    if (scan.sequence > 300) {
      commands.haptic = {.id = 1, .active = true, .duration_s = 0.05, .amplitude = 1, .frequency_Hz = 100};
    }
    return commands;
  };
  while (scenario.Step(nothing, pulse)) felt += scenario.current_A() > 0.1 ? 1 : 0;
  EXPECT_EQ(scenario.output.haptic_pulses, 1U);
  EXPECT_GT(felt, 30);
  EXPECT_LT(felt, 70);
  EXPECT_EQ(scenario.current_A(), 0);
}

TEST(LoopScenario, GarbageScansKeepCurrentsFiniteAndBounded) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(PressAndSlide(), 3.0);
  std::uint64_t random = 88172645463325252ULL;
  const auto next = [&] {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    return random;
  };
  while (scenario.Step(table)) {
    if (next() % 5 != 0) continue;
    base::HallScan bad = scenario.scan;
    const double nasty[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300,
                            -1, 0};
    for (int i = 0; i < 4; ++i) {
      bad.field_sensor_T[next() % 8].y = nasty[next() % 5];
      bad.coil_current_A[next() % 3] = nasty[next() % 5];
      bad.coil_temperature_C[next() % 3] = nasty[next() % 5];
    }
    bad.t_ns += static_cast<std::int64_t>(next() % 4'000'000) - 2'000'000;
    loop::Tick(scenario.config, bad, Scenario::Open(bad), table, scenario.state, scenario.output);
    for (const double i : scenario.output.currents.current_A) {
      ASSERT_TRUE(std::isfinite(i));
      ASSERT_LE(std::abs(i), scenario.config.actuation.current_max_A * (1 + 1e-9));
    }
    ASSERT_LE(scenario.force_N(), 2.0 + 1e-9);
  }
}

}  // namespace test_loop_scenario
}  // namespace omni::test
