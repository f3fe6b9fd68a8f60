// Poses that an application sets in its scene, as the tick follows them.
#include <gtest/gtest.h>

#include "service/haptics/contact/frame.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/scene_motion.h"
#include "tests/haptics/scenario.h"
#include "tests/support/alloc_probe.h"

namespace omni::loop {
namespace test_loop_scene_motion {

constexpr std::int64_t kMs = 1'000'000;

haptics::Scene TwoBlocks() {
  haptics::SceneInput input = haptics::SceneOf(haptics::Block(1, {0.01, 0.01, 0.01}, {0.1, 0, 0}));
  input.objects.push_back(haptics::Block(1, {0.01, 0.02, 0.01}, {-0.1, 0.05, 0.02}));
  for (haptics::InputObject& object : input.objects) object.kinematic = true;
  return haptics::Built(input);
}

PoseSample Sample(haptics::Random& random, std::int64_t t_ns, std::uint64_t number) {
  const base::Vec3 axis = base::Normalized(random.InBox(1));
  const double half = random.Uniform(-0.05, 0.05);
  PoseSample sample;
  sample.t_ns = t_ns;
  sample.number = number;
  sample.rotation = {std::cos(half), std::sin(half) * axis.x, std::sin(half) * axis.y, std::sin(half) * axis.z};
  sample.position_m = random.InBox(0.002);
  sample.angular_velocity_rad_s = random.InBox(0.1);
  return sample;
}

// Given for the scene's origin, followed about the body's middle: at the sample's time every point is in its place.
TEST(SceneMotion, ReachesTheSampledPoseAtItsTime) {
  const haptics::Scene scene = TwoBlocks();
  haptics::Random random(91);
  for (int trial = 0; trial < 50; ++trial) {
    SceneControl control{.generation = 1};
    SceneMotionState state;
    SceneNow now;
    control.object_count = 2;
    FollowScene(control, scene, 0, state, now);
    ASSERT_EQ(now.object_count, 0U) << "they have no samples yet";
    control.placement = Sample(random, 60 * kMs, 1);
    for (std::uint32_t i = 0; i < 2; ++i) {
      control.objects[i] = {.object = 1 - i, .pose = Sample(random, 60 * kMs, 2 + i)};
    }
    FollowScene(control, scene, 10 * kMs, state, now);
    EXPECT_TRUE(now.leaps) << "a first placement is no motion";
    FollowScene(control, scene, 60 * kMs, state, now);
    EXPECT_FALSE(now.leaps);
    ASSERT_EQ(now.object_count, 2U);
    for (std::uint32_t i = 0; i < 2; ++i) {
      const PoseSample& said = control.objects[i].pose;
      const haptics::ObjectPose& there = now.objects[i];
      EXPECT_EQ(there.object, 1 - i);
      for (int k = 0; k < 10; ++k) {
        const base::Vec3 p = random.InBox(0.1);
        const haptics::Frame wanted{false, said.rotation, said.position_m},
            got{false, there.rotation, there.translation_m};
        ASSERT_LT(Norm(wanted.ToBase(p) - got.ToBase(p)), 1e-9) << trial;
      }
    }
  }
}

// Poses that are set before the scene is active are where it starts.
TEST(SceneMotion, EnteredSceneStartsAtItsSampledPose) {
  const haptics::Scene scene = TwoBlocks();
  haptics::Random random(92);
  SceneControl control{.generation = 1};
  control.object_count = 1;
  control.objects[0] = {.object = 0, .pose = Sample(random, 0, 5)};
  SceneMotionState state;
  SceneNow now;
  FollowScene(control, scene, 500 * kMs, state, now);
  ASSERT_EQ(now.object_count, 1U);
  EXPECT_TRUE(now.objects[0].leaps);
  control.objects[0].pose = Sample(random, 520 * kMs, 6);
  FollowScene(control, scene, 510 * kMs, state, now);
  EXPECT_FALSE(now.objects[0].leaps) << "from now on it moves";
}

TEST(SceneMotion, IgnoresInvalidSamplesWithoutAllocating) {
  const haptics::Scene scene = TwoBlocks();
  haptics::Random random(93);
  SceneControl control{.generation = 1};
  control.object_count = 1000;
  for (ObjectSample& sample : control.objects) sample = {.object = 99, .pose = Sample(random, 0, 1)};
  control.objects[3].object = 1;
  control.objects[4].object = 0;
  control.objects[4].pose.position_m.x = std::nan("");
  control.placement.number = 1;
  control.placement.rotation = {0, 0, 0, 0};
  SceneMotionState state;
  SceneNow now;
  const AllocProbe probe;
  FollowScene(control, scene, kMs, state, now);
  EXPECT_EQ(probe.count(), 0U);
  ASSERT_EQ(now.object_count, 1U);
  EXPECT_EQ(now.objects[0].object, 1U);
  EXPECT_EQ(now.placement, haptics::Placement{});
  FollowScene(control, haptics::Scene(), kMs, state, now);
  EXPECT_EQ(now.object_count, 0U);
}

}  // namespace test_loop_scene_motion
}  // namespace omni::loop
