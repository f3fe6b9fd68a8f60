// A simulated person drives a lap on the shipped track through the whole loop in virtual time, whatever the pen and the
// base, and however late or seldom the car is seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "service/tools/hand/person.h"
#include "service/tools/scene/scene.h"
#include "tests/support/rig/guided_hand_scenario.h"

namespace omni::test {
namespace test_hand_race {

constexpr int kSeedsPerBlock = 10;
constexpr double kPatience_s = 60;

const haptics::Scene& Track() {
  static const tools::LoadedScene kTrack =
      std::move(tools::LoadScene(OMNI_SOURCE_DIR "/scenes/racetrack.glb", {}, false).value());
  return kTrack.scene;
}

const sim::HandScript& RaceHand() {
  static const sim::HandScript kHand = sim::LoadHandScript(OMNI_SOURCE_DIR "/scenes/racetrack.hand.json").value();
  return kHand;
}

class HandRace : public testing::TestWithParam<int> {};

TEST_P(HandRace, FinishesALapAtAnyDisplayDelay) {
  double sum_s = 0, longest_s = 0;
  std::uint32_t hits = 0;
  for (int k = 0; k < kSeedsPerBlock; ++k) {
    const auto seed = static_cast<std::uint64_t>(GetParam() * kSeedsPerBlock + k + 1);
    const auto intent = tools::IntentFor(Track(), {});
    ASSERT_TRUE(intent.ok()) << intent.error();
    LedScenario scenario(Track(), RaceHand(), seed, Conditions::Drawn(seed));
    EXPECT_TRUE(scenario.Run(*intent->task, kPatience_s)) << "seed " << seed << ": " << intent->task->Summary();
    EXPECT_GE(scenario.output().haptics.vehicle.laps, 1U) << "seed " << seed;
    hits += scenario.output().haptics.vehicle.hits;
    sum_s += scenario.t_s();
    longest_s = std::max(longest_s, scenario.t_s());
  }
  std::printf("[ figure   ] %.1f s in the mean, %.1f s at most, %u hits in %d races\n", sum_s / kSeedsPerBlock,
              longest_s, hits, kSeedsPerBlock);
}

INSTANTIATE_TEST_SUITE_P(Seeds, HandRace, testing::Range(0, 6));

TEST(HandRaceAlone, LapWithoutVisualDelayIsFastAndHitFree) {
  const auto intent = tools::IntentFor(Track(), {});
  ASSERT_TRUE(intent.ok()) << intent.error();
  LedScenario scenario(Track(), RaceHand(), 1, {});
  EXPECT_TRUE(scenario.Run(*intent->task, kPatience_s)) << intent->task->Summary();
  EXPECT_LT(scenario.t_s(), 13);
  EXPECT_EQ(scenario.output().haptics.vehicle.hits, 1U) << "only the wall that it is driven into after the lap";
}

}  // namespace test_hand_race
}  // namespace omni::test
