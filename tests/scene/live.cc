// Live parts of a scene: which are made, from where, and that copies start in the initial state.
#include <gtest/gtest.h>

#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/sculpted_scene.h"
#include "service/scene/load_scene.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/same_bits.h"
#include "tests/support/touch/fresh_scene.h"

namespace omni::scene {
namespace test_scene_live {

using namespace haptics;

constexpr std::uint32_t kTets = 300;

SceneInput JellyAndClay() {
  SceneInput input = SceneOf(Sphere(8, 0.01));
  input.materials[0].softness.model = SoftnessModel::kTet;
  Material& clay = input.materials.emplace_back();
  clay.sculpt.enabled = true;
  clay.sculpt.grab_force_N = 0.1;
  clay.sculpt.dwell_s = 0.05;
  clay.sculpt.resistance_N_m = 50;
  InputObject& block = input.objects.emplace_back(Block(8, {0.01, 0.01, 0.01}, {0.05, 0, 0}));
  for (std::uint16_t& material : block.triangle_material) material = 1;
  return input;
}

// The pen presses the clay in, waits and lifts; the bits of all forces.
std::vector<Vec3> FormedBy(Scene scene) {
  sculpt::VirtualEditor editor(scene);
  Pen pen(std::move(scene));
  std::vector<Vec3> forces_N;
  const auto go = [&](const Vec3& to, int ticks) {
    const Vec3 from = pen.state.last_device_point_base_m;
    for (int k = 1; k <= ticks; ++k) {
      forces_N.push_back(pen.MoveTo(from + (static_cast<double>(k) / ticks) * (to - from)).force_base_N);
      editor.AfterTick();
    }
  };
  pen.MoveTo({0.05, 0, 0.015});
  go({0.05, 0, 0.0085}, 300);
  go({0.05, 0, 0.0065}, 600);
  go({0.05, 0, 0.02}, 400);
  return forces_N;
}

std::uint64_t GenerationOf(const Scene& scene) {
  return scene.live()->sculpt_session_at(0).editor().publisher().generation();
}

TEST(LiveScene, CachedSoftBodiesMatchBuiltOnes) {
  const test::TempFolder folder;
  CacheStore cache(folder.Path("cache"));
  Scene scenes[] = {Built(JellyAndClay()), Built(JellyAndClay()), Built(JellyAndClay())};
  for (int k = 0; k < 3; ++k) {
    const LiveReport report = LoadLive(scenes[k], k == 0 ? nullptr : &cache, kTets);
    EXPECT_TRUE(report.lines.empty()) << report.lines.front();
    EXPECT_EQ(report.soft_bodies, 1U);
    EXPECT_EQ(report.sculpt_sessions, 1U);
    const auto made = scenes[0].live()->soft_body(0)->bytes(), now = scenes[k].live()->soft_body(0)->bytes();
    EXPECT_TRUE(std::equal(made.begin(), made.end(), now.begin(), now.end())) << k;
  }
}

TEST(LiveScene, UntaggedSceneHasNoLiveParts) {
  Scene scene = Built(SceneOf(Sphere(8, 0.01)));
  const LiveReport report = LoadLive(scene, nullptr);
  EXPECT_EQ(report.soft_bodies + report.sculpt_sessions, 0U);
  EXPECT_EQ(scene.live(), nullptr);
}

// The block that was formed stays formed; its copy is as it was, with the same soft body, and so is each run in a copy.
TEST(LiveScene, FreshCopyStartsInTheInitialState) {
  Scene scene = Built(JellyAndClay());
  ASSERT_TRUE(LoadLive(scene, nullptr, kTets).lines.empty());
  const Scene copy = omni::test::FreshCopy(scene);
  const std::vector<Vec3> first_N = FormedBy(scene);
  EXPECT_GT(GenerationOf(scene), 2U) << "nothing was formed";
  EXPECT_EQ(GenerationOf(copy), 1U);
  const auto body = scene.live()->soft_body(0)->bytes(), copied = copy.live()->soft_body(0)->bytes();
  EXPECT_TRUE(std::equal(body.begin(), body.end(), copied.begin(), copied.end()));
  for (const Scene& fresh : {copy, omni::test::FreshCopy(scene)}) {
    const std::vector<Vec3> again_N = FormedBy(fresh);
    ASSERT_EQ(again_N.size(), first_N.size());
    for (std::size_t k = 0; k < first_N.size(); ++k) ASSERT_TRUE(support::SameBits(first_N[k], again_N[k])) << k;
  }
}

}  // namespace test_scene_live
}  // namespace omni::scene
