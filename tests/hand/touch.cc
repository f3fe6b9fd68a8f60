// A simulated person forms clay and dents a soft body through the whole loop in virtual time, whatever the pen and the
// base, and however late or seldom it is seen and felt.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "service/haptics/scene/scene.h"
#include "service/tools/hand/person.h"
#include "service/tools/scene/scene.h"
#include "tests/haptics/scenario.h"
#include "tests/support/rig/guided_hand_scenario.h"

namespace omni::test {
namespace test_hand_touch {

constexpr int kSeedsPerBlock = 10;
constexpr double kPatience_s = 60;
constexpr tools::PlaceOptions kPlaces{.reach_m = 0.010, .places = 8};

struct Times {
  double sum_s = 0, longest_s = 0;
  void Add(double t_s) {
    sum_s += t_s;
    longest_s = std::max(longest_s, t_s);
  }
  void Print(const char* what) const {
    std::printf("[ figure   ] %s: %.1f s in the mean, %.1f s at most\n", what, sum_s / kSeedsPerBlock, longest_s);
  }
};

class HandTouch : public testing::TestWithParam<int> {
 protected:
  static std::uint64_t Seed(int k) { return static_cast<std::uint64_t>(GetParam() * kSeedsPerBlock + k + 1); }
};

TEST_P(HandTouch, SculptsClayAtAnyFeedbackDelay) {
  const auto hand = sim::LoadHandScript(OMNI_SOURCE_DIR "/scenes/extrusion.hand.json").value();
  Times times;
  for (int k = 0; k < kSeedsPerBlock; ++k) {
    auto loaded = tools::LoadScene(OMNI_SOURCE_DIR "/scenes/extrusion.glb", {}, false);
    ASSERT_TRUE(loaded.ok()) << loaded.error();
    scene::LoadLive(loaded->scene, nullptr);
    const auto intent = tools::IntentFor(loaded->scene, kPlaces);
    ASSERT_TRUE(intent.ok()) << intent.error();
    LedScenario scenario(loaded->scene, hand, Seed(k), Conditions::Drawn(Seed(k)));
    EXPECT_TRUE(scenario.Run(*intent->task, kPatience_s)) << "seed " << Seed(k) << ": " << intent->task->Summary();
    EXPECT_GE(loaded->scene.live()->sculpt_session_at(0).editor().undo_steps(), 2U) << "seed " << Seed(k);
    times.Add(scenario.t_s());
  }
  times.Print("clay");
}

TEST_P(HandTouch, DentsASoftBodyAtAnyDisplayDelay) {
  haptics::Material rubber;
  rubber.softness.model = haptics::SoftnessModel::kTet;
  rubber.softness.young_modulus_Pa = 5e4;
  static haptics::Scene body = [&] {
    haptics::Scene built =
        haptics::Built(haptics::SceneOf(haptics::Block(8, {0.02, 0.02, 0.008}, {0, 0, 0.048}), rubber));
    EXPECT_EQ(scene::LoadLive(built, nullptr, 400).soft_bodies, 1U);
    return built;
  }();
  const auto hand = sim::LoadHandScript(OMNI_SOURCE_DIR "/scenes/dragon.hand.json").value();
  Times times;
  for (int k = 0; k < kSeedsPerBlock; ++k) {
    const auto intent = tools::IntentFor(body, kPlaces);
    ASSERT_TRUE(intent.ok()) << intent.error();
    LedScenario scenario(body, hand, Seed(k), Conditions::Drawn(Seed(k)));
    EXPECT_TRUE(scenario.Run(*intent->task, kPatience_s)) << "seed " << Seed(k) << ": " << intent->task->Summary();
    times.Add(scenario.t_s());
  }
  times.Print("soft");
}

TEST_P(HandTouch, PressesFirmSurfacesAtAnyFeedbackDelay) {
  const haptics::Scene table = TableScene(kTableTop_m);
  Times times;
  for (int k = 0; k < kSeedsPerBlock; ++k) {
    const auto intent = tools::IntentFor(table, kPlaces);
    ASSERT_TRUE(intent.ok()) << intent.error();
    LedScenario scenario(table, PressAndSlide(), Seed(k), Conditions::Drawn(Seed(k)));
    EXPECT_TRUE(scenario.Run(*intent->task, kPatience_s)) << "seed " << Seed(k) << ": " << intent->task->Summary();
    times.Add(scenario.t_s());
  }
  times.Print("firm");
}

INSTANTIATE_TEST_SUITE_P(Seeds, HandTouch, testing::Range(0, 6));

}  // namespace test_hand_touch
}  // namespace omni::test
