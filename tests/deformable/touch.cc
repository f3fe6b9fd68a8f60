// Soft bodies in the tick: a pen presses, slides on and leaves a body that deforms.
#include "service/haptics/contact/effects.h"
#include "service/haptics/contact/frame.h"
#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"
#include "tests/deformable/scenario.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/same_bits.h"
#include "tests/support/soft_step.h"

namespace omni::haptics {
namespace test_deformable_touch {

constexpr double kRadius_m = 0.03;  // of the ball

Material Jelly() {
  Material material;
  material.stiffness_N_m = 900;
  material.static_friction = material.dynamic_friction = 0;
  material.softness = {.model = SoftnessModel::kTet, .young_modulus_Pa = kSoftModulus_Pa, .poisson_ratio = 0.4};
  return material;
}

std::unique_ptr<const SoftBody> Copy(const SoftBody& body) { return std::make_unique<const SoftBody>(body); }

// The ball; with its body at once unless `later`.
Scene SoftScene(const Material& material, bool later = false, bool kinematic = false, double tip_radius_m = 0) {
  SceneInput input = SceneOf(Sphere(48, kRadius_m), material);  // finer than the body was made from
  input.tip_radius_m = tip_radius_m;
  input.objects[0].kinematic = kinematic;
  Scene scene = Built(input);
  auto live = std::make_shared<LiveParts>();
  if (!later) live->SetSoftBody(0, Copy(SoftBall()));
  scene.SetLive(std::move(live));
  return scene;
}

// Of a ball pressed in at the place, once it has relaxed: body and spring in series.
double ModelForce(const Vec3& direction, double depth_m, double stiffness_N_m, double tip_m = kIndenterRadius_m) {
  SoftContactState state{};
  const Vec3 n = Normalized(direction);
  const SoftContact contact{true, kRadius_m * n, n, depth_m, 1 / stiffness_N_m};
  for (int k = 0; k < 3000; ++k) support::StepSoftContact(SoftBall().view(), contact, tip_m, 1e-3, state);
  return support::StepSoftContact(SoftBall().view(), contact, tip_m, 1e-3, state).normal_N;
}

TEST(SoftTouch, RestForceMatchesBodyInSeriesWithContactSpring) {
  for (const Vec3& at : {Vec3{0, 0, 1}, Vec3{1, 0.2, 0.3}, Vec3{-0.3, 0.6, 0.5}}) {
    Pen pen(SoftScene(Jelly()));
    const Vec3 n = Normalized(at);
    pen.Slide(0.034 * n, 0.0275 * n, 300);
    pen.Rest(1500);
    ASSERT_EQ(pen.output.contact_count, 1);
    // The surface is a polyhedron: the depth is that under its faces.
    const double depth_m = -pen.output.contacts[0].gap_m;
    EXPECT_NEAR(depth_m, 0.0025, 3e-4);
    const double expected_N = ModelForce(at, depth_m, 900);
    EXPECT_NEAR(Norm(pen.output.force_base_N) / expected_N, 1, 0.02);
    EXPECT_GT(Dot(Normalized(pen.output.force_base_N), n), 0.995);
    // Shown on the deformed surface: at the tip, but for what the spring gives.
    EXPECT_LT(Norm(pen.output.contacts[0].point_base_m - 0.0275 * n), expected_N / 900 + 2e-4);
  }
}

// A tip that is a ball presses with its own radius, from where it touches.
TEST(SoftTouch, BallTipPressesWithItsOwnRadius) {
  const Vec3 n = base::Normalized({0.2, -0.1, 1});
  Pen pen(SoftScene(Jelly(), false, false, kTip_m));
  pen.Slide(0.04 * n, 0.0325 * n, 300);
  pen.Rest(1500);
  ASSERT_EQ(pen.output.contact_count, 1);
  const double depth_m = -pen.output.contacts[0].gap_m;
  EXPECT_NEAR(depth_m, 0.0025, 3e-4);
  EXPECT_NEAR(Norm(pen.output.force_base_N) / ModelForce(n, depth_m, 900, kTip_m), 1, 0.02);
  pen.Slide(0.0325 * n, 0.036 * n, 100);
  EXPECT_EQ(pen.output.contact_count, 0);
}

struct Prepared {
  InputObject mesh;
  const SoftBody& body;
  Vec3 top;  // where it is pressed, down
};

// Before the body is ready its material is felt under the same ball: of any radius, at any depth.
TEST(SoftTouch, StandInIsWithin15PercentOfTheBody) {
  static const base::Result<SoftBody> box = BuildSmall(SoftBoxMesh(), SmallOptions());
  for (const Prepared& prepared : {Prepared{Sphere(24, kRadius_m), SoftBall(), {0, 0, kRadius_m}},
                                   Prepared{SoftBoxMesh(), *box, {0.004, 0.003, 0.03}}}) {
    for (const double radius_m : {0.0002, 0.0005, 0.001, 0.0015, 0.002, 0.003}) {
      SceneInput input = SceneOf(prepared.mesh, Jelly());
      input.tip_radius_m = radius_m;
      Scene ready = Built(input);
      auto live = std::make_shared<LiveParts>();
      live->SetSoftBody(0, Copy(prepared.body));
      ready.SetLive(std::move(live));
      Pen with(ready), before(Built(input));
      for (const double depth_m : {2e-4, 5e-4, 1e-3, 2e-3, 3e-3}) {
        for (Pen* pen : {&with, &before}) {
          pen->Slide(prepared.top + Vec3{0, 0, radius_m + 0.001}, prepared.top + Vec3{0, 0, radius_m - depth_m}, 50);
          pen->Rest(600);
        }
        const double body_N = with.output.force_base_N.z, stand_in_N = before.output.force_base_N.z;
        EXPECT_GT(body_N, 0) << radius_m << " " << depth_m;
        EXPECT_NEAR(stand_in_N / body_N, 1, 0.15) << radius_m << " " << depth_m << ", " << body_N << " N";
      }
    }
  }
}

// Pressed, held and released it relaxes as the body does.
TEST(SoftTouch, StandInRelaxesAsTheBodyDoes) {
  Pen with(SoftScene(Jelly(), false, false, 0.0015)), before(SoftScene(Jelly(), true, false, 0.0015));
  double worst_N = 0, largest_N = 0;
  for (int k = 0; k < 900; ++k) {
    const double height_m = 0.0325 - 0.0025 * std::min({1.0, k / 60.0, (900 - k) / 300.0});
    with.MoveTo({0, 0, height_m});
    before.MoveTo({0, 0, height_m});
    worst_N = std::max(worst_N, std::abs(with.output.force_base_N.z - before.output.force_base_N.z));
    largest_N = std::max(largest_N, with.output.force_base_N.z);
  }
  EXPECT_GT(largest_N, 0.1);
  EXPECT_LT(worst_N, 0.1 * largest_N);
}

// A body that becomes ready under the pen waits until the contact ends: until then not a bit changes.
TEST(SoftTouch, NewSoftBodyWaitsUntilContactEnds) {
  Pen with(SoftScene(Jelly(), true)), without(SoftScene(Jelly(), true));
  const auto go = [&](double height_m) {
    with.MoveTo({0, 0, height_m});
    without.MoveTo({0, 0, height_m});
  };
  for (int k = 0; k < 200; ++k) go(0.033 - 2.5e-5 * k);
  with.scene().live()->SetSoftBody(0, Copy(SoftBall()));
  for (int k = 0; k < 200; ++k) {
    go(0.028);
    ASSERT_TRUE(support::SameBits(with.output.force_base_N, without.output.force_base_N));
  }
  for (int k = 0; k < 200; ++k) go(0.028 + 2.5e-5 * k);
  EXPECT_EQ(with.output.contact_count, 0);
  for (int k = 0; k < 200; ++k) go(0.033 - 2.5e-5 * k);
  EXPECT_EQ(with.state.is_soft[0], 1);
  EXPECT_GT(std::abs(with.output.force_base_N.z / without.output.force_base_N.z - 1), 0.05);
}

// Slow or fast, along the surface, in and out: the force never jumps, never pulls, ends when the pen is out, and no
// contact is lost while it is in.
TEST(SoftTouch, ForceNeverJumpsAndContactIsNeverLost) {
  Random random(83);
  for (const double speed_m_s : {0.02, 0.1, 0.5}) {
    Pen pen(SoftScene(Jelly()));
    Vec3 tip{0, 0, 0.036};
    pen.MoveTo(tip);
    const loop::AllocProbe probe;
    double largest_N = 0;
    for (int leg = 0; leg < 60; ++leg) {
      const Vec3 to = random.Uniform(0.0265, 0.033) * Normalized(random.InBox(1) + Vec3{0, 0, 0.8});
      const int ticks = 1 + static_cast<int>(Norm(to - tip) / (1e-3 * speed_m_s));
      for (int k = 1; k <= ticks; ++k) {
        const double share = static_cast<double>(k) / ticks;
        const Vec3 towards = Normalized((1 - share) * tip + share * to);
        const Vec3 at = ((1 - share) * Norm(tip) + share * Norm(to)) * towards;
        const Vec3 before_N = pen.output.force_base_N;
        pen.MoveTo(at);
        const Vec3 force_N = pen.output.force_base_N;
        ASSERT_LT(Norm(force_N - before_N), 0.06 + 1.5 * speed_m_s) << speed_m_s;
        ASSERT_GE(Dot(force_N, at), -1e-6);
        ASSERT_TRUE(Norm(at) > 0.0295 || pen.output.contact_count == 1) << Norm(at);
        ASSERT_TRUE(Norm(at) < 0.0301 || pen.output.contact_count == 0) << Norm(at);
        largest_N = std::max(largest_N, Norm(force_N));
      }
      tip = to;
    }
    EXPECT_EQ(probe.count(), 0U);
    EXPECT_GT(largest_N, 0.8);
  }
}

// Held at a depth the force falls by the relaxing share and stays.
TEST(SoftTouch, ForceRelaxesAtConstantDepth) {
  Pen pen(SoftScene(Jelly()));
  pen.Slide({0, 0, 0.032}, {0, 0, 0.028}, 10);
  const double first_N = pen.output.force_base_N.z;
  pen.Rest(1000);
  const double last_N = pen.output.force_base_N.z;
  EXPECT_LT(last_N, 0.97 * first_N);
  EXPECT_GT(last_N, 0.7 * first_N);
  pen.Rest(500);
  EXPECT_NEAR(pen.output.force_base_N.z, last_N, 0.005 * last_N);
}

// A soft body that stands elsewhere gives the same forces.
TEST(SoftTouch, ForceDoesNotDependOnObjectPose) {
  Pen rest(SoftScene(Jelly(), false, true)), moved(SoftScene(Jelly(), false, true));
  const base::Quat turn{std::cos(0.4), std::sin(0.4) * 0.6, 0, std::sin(0.4) * 0.8};
  const ObjectPose pose{.object = 0, .rotation = turn, .translation_m = {0.05, -0.02, 0.01}};
  const Frame frame{false, turn, pose.translation_m};
  moved.input.poses = {&pose, 1};
  for (int k = 0; k < 600; ++k) {
    const Vec3 tip = (0.033 - 1e-5 * std::min(k, 500)) * base::Normalized({0.2, 1e-3 * k, 1});
    const Vec3 rest_N = rest.MoveTo(tip).force_base_N;
    const Vec3 moved_N = moved.MoveTo(frame.ToBase(tip)).force_base_N;
    ASSERT_LT(Norm(moved_N - Rotated(turn, rest_N)), 1e-4 * (1 + Norm(rest_N)));
  }
  EXPECT_GT(Norm(rest.output.force_base_N), 0.5);
}

// What the body keeps of a contact goes when it ends, when tracking is lost, and with the scene.
TEST(SoftTouch, StateIsClearedWhenContactEnds) {
  Pen pen(SoftScene(Jelly()));
  pen.Slide({0, 0, 0.032}, {0, 0, 0.028}, 100);
  EXPECT_EQ(pen.state.soft[0].object, 0U);
  pen.Slide({0, 0, 0.028}, {0, 0, 0.034}, 100);
  EXPECT_EQ(pen.state.soft[0].object, kNoIndex);
  pen.Slide({0, 0, 0.034}, {0, 0, 0.028}, 100);
  for (int k = 0; k < 40; ++k) pen.Lose();
  EXPECT_EQ(pen.state.soft[0].object, kNoIndex);
  pen.Swap(SoftScene(Jelly()));
  EXPECT_EQ(pen.state.is_soft[0], 0);
}

}  // namespace test_deformable_touch
}  // namespace omni::haptics
