// Objects that the application moves: rendered as if the pen moved the other way.
#include <gtest/gtest.h>

#include "service/haptics/contact/frame.h"
#include "tests/haptics/scenario.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/same_bits.h"

namespace omni::haptics {
namespace test_haptics_moving {

SceneInput Movable(InputObject object, const Material& material = {}) {
  SceneInput input = SceneOf(std::move(object), material);
  input.objects[0].kinematic = true;
  return input;
}

Material Smooth() {
  Material material;
  material.static_friction = material.dynamic_friction = 0;
  return material;
}

base::Quat Turn(const Vec3& axis, double angle_rad) {
  const Vec3 v = std::sin(angle_rad / 2) * Normalized(axis);
  return {std::cos(angle_rad / 2), v.x, v.y, v.z};
}

ObjectPose At(const Vec3& translation_m, const base::Quat& rotation = {}) {
  return {.object = 0, .rotation = rotation, .translation_m = translation_m};
}

// A ball that stands elsewhere and is touched there gives the same forces, friction and reports.
TEST(MovedObjects, ContactDoesNotDependOnObjectPose) {
  Random random(71);
  for (int trial = 0; trial < 20; ++trial) {
    const Frame frame{false, Turn(random.InBox(1), random.Uniform(0, 3)), random.InBox(0.1)};
    Pen rest(Built(Movable(Sphere(8, 0.02)))), moved(Built(Movable(Sphere(8, 0.02))));
    const ObjectPose pose = At(frame.translation_m, frame.rotation);
    moved.input.poses = {&pose, 1};
    Vec3 tip = 0.025 * Normalized(random.InBox(1));
    for (int k = 0; k < 400; ++k) {
      tip = 0.99 * tip + 0.0004 * random.InBox(1);
      if (Norm(tip) < 0.0185) tip = (0.0185 / Norm(tip)) * tip;
      const Vec3 rest_N = rest.MoveTo(tip).force_base_N, moved_N = moved.MoveTo(frame.ToBase(tip)).force_base_N;
      ASSERT_LT(Norm(moved_N - Rotated(frame.rotation, rest_N)), 1e-6);
      ASSERT_EQ(rest.output.contact_count, moved.output.contact_count);
      if (rest.output.contact_count == 0) continue;
      const Contact &a = rest.output.contacts[0], &b = moved.output.contacts[0];
      ASSERT_LT(Norm(frame.ToBase(a.point_base_m) - b.point_base_m), 1e-9);
      ASSERT_LT(Norm(Rotated(frame.rotation, a.normal_base) - b.normal_base), 1e-6);
    }
    EXPECT_GT(rest.output.contact_count, 0);
  }
}

// A plate that rises against a resting pen pushes it, whatever its speed and however thin it is.
TEST(MovedObjects, RisingPlatePushesARestingPen) {
  for (const double speed_m_s : {0.05, 0.5, 5.0}) {
    Pen pen(Built(Movable(Block(2, {0.02, 0.02, 0.00025}), Smooth())));
    double height_m = -0.021;
    ObjectPose pose = At({0, 0, height_m});
    pen.input.poses = {&pose, 1};
    for (int k = 0; k < 250; ++k) pen.MoveTo({});  // the jump from its place in the scene is over
    ASSERT_EQ(pen.output.contact_count, 0);
    while (height_m < 0.0005) {
      height_m = std::min(0.0005, height_m + 1e-3 * speed_m_s);
      pose = At({0, 0, height_m});
      pen.MoveTo({});
    }
    pen.Rest(300);
    ASSERT_EQ(pen.output.contact_count, 1) << speed_m_s;
    EXPECT_NEAR(pen.output.contacts[0].gap_m, -0.00075, 1e-9) << speed_m_s;
    EXPECT_NEAR(pen.output.force_base_N.z, 0.00075 * 400, 1e-3) << speed_m_s;
  }
}

// A belt under a resting pen drags it along by its friction, no more than the cone allows; a pen that goes with the
// belt gets the normal force only, and no damping.
TEST(MovedObjects, MovingBeltDragsARestingPenByFriction) {
  Material rough;
  rough.static_friction = rough.dynamic_friction = 0.3;
  rough.damping_Ns_m = 2;
  Pen still(Built(Movable(Block(4, {0.2, 0.05, 0.01}), rough))),
      carried(Built(Movable(Block(4, {0.2, 0.05, 0.01}), rough)));
  ObjectPose pose = At({});
  still.input.poses = carried.input.poses = {&pose, 1};
  double x_m = 0;
  const auto roll = [&](int ticks) {
    for (int k = 0; k < ticks; ++k) {
      x_m += 1e-4;
      pose = At({x_m, 0, 0});
      still.MoveTo({0, 0, 0.009});
      carried.MoveTo({x_m, 0, 0.009});
    }
  };
  still.Slide({0, 0, 0.012}, {0, 0, 0.009}, 100);
  carried.Slide({0, 0, 0.012}, {0, 0, 0.009}, 100);
  roll(200);
  EXPECT_NEAR(still.output.force_base_N.x, 0.3 * 0.4, 1e-3);
  EXPECT_NEAR(carried.output.force_base_N.x, 0, 1e-6);
  EXPECT_NEAR(carried.output.force_base_N.z, 0.4, 1e-3);
  // Turning its back: friction goes over to the other side, within the cone.
  for (int k = 0; k < 200; ++k) {
    x_m -= 1e-4;
    pose = At({x_m, 0, 0});
    still.MoveTo({0, 0, 0.009});
    ASSERT_LE(std::abs(still.output.force_base_N.x), 0.3 * still.output.force_base_N.z * 1.001 + 1e-6);
  }
  EXPECT_NEAR(still.output.force_base_N.x, -0.3 * 0.4, 1e-3);
}

// Put around the pen and taken away: no motion, so nothing is swept; the force comes and goes gently.
TEST(MovedObjects, TeleportedObjectDoesNotKick) {
  Pen pen(Built(Movable(Block(2, {0.01, 0.01, 0.01}), Smooth())));
  ObjectPose pose = At({0.5, 0, 0});
  pen.input.poses = {&pose, 1};
  double step_N = 0;
  const auto watch = [&](int ticks) {
    for (int k = 0; k < ticks; ++k) {
      const Vec3 before_N = pen.output.force_base_N;
      pen.MoveTo({0, 0, 0.008});
      step_N = std::max(step_N, Norm(pen.output.force_base_N - before_N));
    }
  };
  watch(10);
  EXPECT_EQ(pen.output.contact_count, 0);
  pose = At({});
  watch(40);
  ASSERT_EQ(pen.output.contact_count, 1);
  EXPECT_NEAR(pen.output.force_base_N.z, 0.8, 0.02);
  pose = At({0.5, 0, 0});
  watch(40);
  EXPECT_EQ(pen.output.force_base_N, Vec3{});
  EXPECT_LT(step_N, 0.1);
}

TEST(MovedObjects, InvalidPosesAreIgnored) {
  const double nan = std::nan("");
  const base::Quat one;
  const std::vector<ObjectPose> bad = {{0, {nan, 0, 0, 0}, {}}, {0, {0, 0, 0, 0}, {}},     {0, {2, 0, 0, 0}, {}},
                                       {0, one, {nan, 0, 0}},   {0, one, {0, 1e30, 0}},    {1, one, {0, 0, 0.001}},
                                       {7, one, {0, 0, 1}},     {kNoIndex, one, {0, 0, 1}}};
  SceneInput input = Movable(Block(2, {0.01, 0.01, 0.01}));
  input.objects.push_back(Block(2, {0.01, 0.01, 0.01}, {0.1, 0, 0}));  // not to be moved
  Pen with(Built(input)), without(Built(input));
  with.input.poses = bad;
  for (int k = 0; k < 200; ++k) {
    const Vec3 tip{0.1 * (k % 2), 1e-5 * k, 0.012 - 2e-5 * k};
    with.MoveTo(tip);
    without.MoveTo(tip);
    ASSERT_TRUE(support::SameBits(with.output.force_base_N, without.output.force_base_N)) << k;
  }
}

// The motion bound must not hide an object that comes from afar; and nothing is taken from the heap.
TEST(MovedObjects, ObjectApproachingFromAfarIsFoundWithoutAllocation) {
  Pen pen(Built(Movable(Sphere(16, 0.01), Smooth())));
  ObjectPose pose = At({0.3, 0, 0});
  pen.input.poses = {&pose, 1};
  for (int k = 0; k < 300; ++k) pen.MoveTo({});
  const loop::AllocProbe probe;
  for (int k = 0; k <= 2000; ++k) {
    pose = At({0.3 - 1.46e-4 * k, 0, 0}, Turn({1, 2, 3}, 1e-3 * k));
    pen.MoveTo({});
  }
  EXPECT_EQ(probe.count(), 0U);
  ASSERT_EQ(pen.output.contact_count, 1);
  EXPECT_NEAR(pen.output.contacts[0].gap_m, -0.002, 1e-4);
}

}  // namespace test_haptics_moving
}  // namespace omni::haptics
