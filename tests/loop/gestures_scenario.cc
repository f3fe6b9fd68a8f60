// Gestures with the whole loop and the simulated pen: noise, heat, a hand that yields, forces that push back.
#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "service/haptics/scene/scene.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_loop_gestures_scenario {

using base::InputSource;

constexpr double kAbove_m = kTableTop_m + 0.008;

struct Counts {
  int taps = 0, doubles = 0, presses = 0, detents = 0, flicks = 0;
  double peak_N = 0;
};

Counts Play(const sim::HandScript& script, std::uint64_t seed, double stiffness_N_m = 400) {
  const haptics::Scene table = TableScene(kTableTop_m, stiffness_N_m);
  Scenario scenario(script, script.duration_s(), seed);
  Counts counts;
  base::SourceMask before = 0;
  while (scenario.Step(table)) {
    const base::SourceMask rose = scenario.output.sources & ~before;
    before = scenario.output.sources;
    const auto count = [rose](InputSource source) { return (rose & SourceBit(source)) != 0 ? 1 : 0; };
    counts.taps += count(InputSource::kTap);
    counts.doubles += count(InputSource::kDoubleTap);
    counts.presses += count(InputSource::kPress);
    counts.detents += count(InputSource::kDetent);
    counts.flicks += count(InputSource::kFlick) + count(InputSource::kFlickAxial);
    counts.peak_N = std::max(counts.peak_N, scenario.force_N());
  }
  return counts;
}

sim::HandScript Above() {
  sim::HandScript script;
  script.name = "gestures";
  script.tremor_m = 1e-4;
  script.waypoints = {{.duration_s = 0, .tip_base_m = {0, 0, kAbove_m}},
                      {.duration_s = 0.4, .tip_base_m = {0, 0, kAbove_m}}};
  return script;
}

TEST(GestureScenario, DetectsEveryTapOnATable) {
  std::mt19937_64 random(20264);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
  int taps = 0, found = 0, presses = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    sim::HandScript script = Above();
    const int count = 5;
    for (int i = 0; i < count; ++i) {
      const double x_m = uniform(-0.008, 0.008), down_s = uniform(0.09, 0.16), deep_m = uniform(0.003, 0.006);
      script.waypoints.push_back({.duration_s = 0.3, .tip_base_m = {x_m, 0, kAbove_m}});
      script.waypoints.push_back({.duration_s = down_s, .tip_base_m = {x_m, 0, kTableTop_m - deep_m}});
      script.waypoints.push_back({.duration_s = down_s, .tip_base_m = {x_m, 0, kAbove_m}});
      script.waypoints.push_back({.duration_s = 0.4, .tip_base_m = {x_m, 0, kAbove_m}});
    }
    const Counts counts = Play(script, seed);
    EXPECT_EQ(counts.taps, count) << "seed " << seed;
    EXPECT_EQ(counts.doubles, 0) << "seed " << seed;
    taps += count;
    found += counts.taps;
    presses += counts.presses;
  }
  std::printf("twin: %d of %d taps found, %d presses\n", found, taps, presses);
}

TEST(GestureScenario, HoveringAndTracingCauseNoTaps) {
  int taps = 0, flicks = 0;
  double seconds = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    sim::HandScript script = Above();
    script.waypoints.push_back({.duration_s = 0.6, .tip_base_m = {0, 0, kTableTop_m + 0.0003}});
    script.waypoints.push_back({.duration_s = 3.0, .tip_base_m = {0.002, 0, kTableTop_m - 0.0002}});
    script.waypoints.push_back({.duration_s = 0.4, .tip_base_m = {0, 0, kTableTop_m - 0.005}});
    for (int i = 0; i < 4; ++i) {
      script.waypoints.push_back(
          {.duration_s = 0.7, .tip_base_m = {i % 2 == 0 ? 0.012 : -0.012, 0, kTableTop_m - 0.005}});
    }
    script.waypoints.push_back({.duration_s = 0.4, .tip_base_m = {0, 0, kAbove_m}});
    const Counts counts = Play(script, seed);
    EXPECT_EQ(counts.taps, 0) << "seed " << seed;
    EXPECT_EQ(counts.flicks, 0) << "seed " << seed;
    EXPECT_GE(counts.presses, 1) << "seed " << seed;
    taps += counts.taps;
    flicks += counts.flicks;
    seconds += script.duration_s();
  }
  std::printf("twin: %d taps, %d flicks in %.1f s of hovering and tracing\n", taps, flicks, seconds);
}

TEST(GestureScenario, PressingHardClicksOnceAndRendersTheDetent) {
  sim::HandScript script = Above();
  script.waypoints.push_back({.duration_s = 0.6, .tip_base_m = {0, 0, kTableTop_m - 0.012}});
  script.waypoints.push_back({.duration_s = 0.8, .tip_base_m = {0, 0, kTableTop_m - 0.012}});
  script.waypoints.push_back({.duration_s = 0.6, .tip_base_m = {0, 0, kAbove_m}});
  const haptics::Scene table = TableScene(kTableTop_m);
  Scenario scenario(script, script.duration_s());
  double felt_N = 0;
  int clicks = 0;
  bool before = false;
  while (scenario.Step(table)) {
    const bool on = (scenario.output.sources & SourceBit(InputSource::kDetent)) != 0;
    clicks += on && !before ? 1 : 0;
    before = on;
    if (scenario.state.detent.time_s < loop::kDetentPulse_s) {
      felt_N = std::max(felt_N, scenario.output.haptics.force_base_N.z - scenario.output.wrench.force_N.z);
    }
  }
  EXPECT_EQ(clicks, 1);
  EXPECT_GT(felt_N, 0.08) << "the surface yields, in the commanded force";
  const base::InputValue& squeeze =
      scenario.output.inputs.components[static_cast<std::size_t>(base::InputComponent::kSqueeze)];
  EXPECT_EQ(squeeze.press_count, 1U);
  EXPECT_EQ(squeeze.release_count, 1U);
}

}  // namespace test_loop_gestures_scenario
}  // namespace omni::test
