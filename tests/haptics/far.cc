// A tip that is far from everything takes a fast path through the tick: its results must be bit-identical to the full
// path.
#include <gtest/gtest.h>

#include "service/haptics/scene/scene.h"
#include "tests/haptics/scenario.h"
#include "tests/support/same_bits.h"

namespace omni::haptics {
namespace test_haptics_far {

// A pen kept off the fast path by a pose that names no object, with a new output each tick.
class LongWay {
 public:
  explicit LongWay(const Scene& scene) : scene_(scene) { EnterScene(scene_, state); }
  const Output& Step(const Config& config, Input input) {
    const ObjectPose nobody;
    input.poses = {&nobody, 1};
    output = {};
    haptics::Step(config, scene_, input, state, output);
    return output;
  }
  State state;
  Output output;

 private:
  const Scene& scene_;
};

Material Rough() {
  Material material;
  material.magnet_max_force_N = 0.2;
  material.texture_amplitude_m = 1e-4;
  return material;
}

// Up and down between contact and 6 cm, aside, with lost poses, jumps and NaN.
class Wanderer {
 public:
  explicit Wanderer(std::uint64_t seed) : random_(seed) {}
  Input Next() {
    const bool leap = random_.Uniform(0, 1) < 0.002;
    if (random_.Uniform(0, 1) < 0.01) goal_m_ = random_.Uniform(0.017, 0.08) * Normalized(random_.InBox(1));
    const Vec3 before_m = tip_m_;
    tip_m_ = leap ? goal_m_ : 0.98 * tip_m_ + 0.02 * goal_m_ + 1e-5 * random_.InBox(1);
    Input input;
    input.t_ns = ++ticks_ * 1'000'000;
    input.dt_s = random_.Uniform(0, 1) < 0.01 ? 7e-3 : 1e-3;
    input.tracked = random_.Uniform(0, 1) > 0.003;
    input.device_point_base_m = tip_m_;
    input.velocity_base_m_s = 1e3 * (tip_m_ - before_m);
    if (random_.Uniform(0, 1) < 0.002) input.velocity_base_m_s.x = std::nan("");
    input.noise = {random_.Uniform(1e-10, 1e-8), 0, 1e-6};
    input.noise_along = {1e-10, 0, 1e-6};
    input.axis_base = {0, 0, -1};
    input.delay_s = 1e-3;
    input.limit = test::UsualLimit();
    return input;
  }

 private:
  Random random_;
  std::int64_t ticks_ = 0;
  Vec3 tip_m_{0, 0, 0.05}, goal_m_{0, 0, 0.05};
};

void WalkBothWays(const Scene& scene, std::uint64_t seed, int& far_ticks, int& touching_ticks) {
  const Config config;
  State state;
  Output output;
  EnterScene(scene, state);
  LongWay slow(scene);
  slow.state = state;  // with its padding: GCC 12's __builtin_clear_padding leaves some of it as it was
  Wanderer wanderer(seed);
  for (int k = 0; k < 5000; ++k) {
    const Input input = wanderer.Next();
    Step(config, scene, input, state, output);
    ASSERT_TRUE(support::SameBits(output, slow.Step(config, input))) << "seed " << seed << ", tick " << k;
    ASSERT_TRUE(support::SameBits(state, slow.state)) << "seed " << seed << ", tick " << k;
    far_ticks += state.far_distance_m > 0;
    touching_ticks += output.contact_count > 0;
  }
}

TEST(FarTip, FastPathIsBitIdenticalToFullStep) {
  const Scene scene = Built(SceneOf(Sphere(8, 0.02), Rough()));
  int far_ticks = 0, touching_ticks = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) WalkBothWays(scene, seed, far_ticks, touching_ticks);
  EXPECT_GT(far_ticks, 5000);
  EXPECT_GT(touching_ticks, 1000);
}

TEST(FarTip, EmptySceneGivesNoForceOrContact) {
  const Config config;
  const Scene none;
  State state;
  Output output;
  EnterScene(none, state);
  Wanderer wanderer(7);
  for (int k = 0; k < 1000; ++k) {
    Step(config, none, wanderer.Next(), state, output);
    ASSERT_EQ(output.force_base_N, Vec3{});
    ASSERT_EQ(output.contact_count, 0);
  }
}

TEST(FarTip, OutputIsClearedAfterLeavingContact) {
  Pen pen(Built(SceneOf(Sphere(8, 0.02))));
  pen.Slide({0, 0, 0.05}, {0, 0, 0.018}, 200);
  ASSERT_GT(pen.output.contact_count, 0);
  pen.Slide({0, 0, 0.018}, {0, 0, 0.06}, 200);
  Output quiet;
  quiet.stiffness_offered_N_m = pen.output.stiffness_offered_N_m;
  EXPECT_TRUE(support::SameBits(pen.output, quiet));
}

}  // namespace test_haptics_far
}  // namespace omni::haptics
