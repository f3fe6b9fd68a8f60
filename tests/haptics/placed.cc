// Scenes that stand somewhere, and move as one body; materials that change while they are in use.
#include <gtest/gtest.h>

#include "service/base/force_limit.h"
#include "service/base/material.h"
#include "service/haptics/contact/frame.h"
#include "service/haptics/live/scene_changes.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/scenario.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/same_bits.h"

namespace omni::haptics {
namespace test_haptics_placed {

base::Quat QuarterAbout(const Vec3& axis, double angle_rad) {
  const Vec3 v = std::sin(angle_rad / 2) * Normalized(axis);
  return {std::cos(angle_rad / 2), v.x, v.y, v.z};
}

// As `Pen`, with the scene at a placement.
struct PlacedPen {
  explicit PlacedPen(const SceneInput& from) : scene(Built(from)) {
    config = {.ramp_s = 0, .delay_s = 0, .coil_lag_s = 0, .predict_max_s = 0};
    input.limit = test::UsualLimit();
    input.tracked = true;
    EnterScene(scene, state);
  }
  const Output& MoveTo(const Vec3& tip_m, const Placement& placement, bool leaps = false) {
    const Vec3 before_N = output.force_base_N;
    input.velocity_base_m_s = moved ? 1e3 * (tip_m - last_m) : Vec3{};
    input.device_point_base_m = last_m = tip_m;
    input.t_ns += 1'000'000;
    moved = true;
    StepPlaced(config, scene, placement, leaps, input, state, output);
    step_N = std::max(step_N, Norm(output.force_base_N - before_N));
    return output;
  }
  Scene scene;
  Config config;
  Input input;
  State state;
  Output output;
  Vec3 last_m;
  bool moved = false;
  double step_N = 0;  // largest change of force within a tick
};

Material Frictionless() {
  Material material;
  material.static_friction = material.dynamic_friction = 0;
  return material;
}

// Friction, textures, prediction and reports are the same wherever the scene stands.
TEST(PlacedScene, ContactDoesNotDependOnPlacement) {
  Random random(501);
  for (int trial = 0; trial < 20; ++trial) {
    const Placement placement{QuarterAbout(random.InBox(1), random.Uniform(0, 3)), random.InBox(0.1)};
    const Frame frame{false, placement.rotation, placement.translation_m};
    PlacedPen rest(SceneOf(Sphere(8, 0.02))), placed(SceneOf(Sphere(8, 0.02)));
    Vec3 tip = 0.025 * Normalized(random.InBox(1));
    placed.MoveTo(frame.ToBase(tip), placement, true);
    rest.MoveTo(tip, {});
    for (int k = 0; k < 400; ++k) {
      tip = 0.99 * tip + 0.0004 * random.InBox(1);
      if (Norm(tip) < 0.0185) tip = (0.0185 / Norm(tip)) * tip;
      const Output& a = rest.MoveTo(tip, {});
      const Output& b = placed.MoveTo(frame.ToBase(tip), placement);
      ASSERT_LT(Norm(b.force_base_N - Rotated(placement.rotation, a.force_base_N)), 1e-6) << trial << " " << k;
      ASSERT_EQ(a.contact_count, b.contact_count);
      if (a.contact_count == 0) continue;
      ASSERT_LT(Norm(frame.ToBase(a.contacts[0].point_base_m) - b.contacts[0].point_base_m), 1e-9);
      ASSERT_LT(Norm(Rotated(placement.rotation, a.contacts[0].slip_base_m_s) - b.contacts[0].slip_base_m_s), 1e-6);
      ASSERT_LT(Norm(Rotated(placement.rotation, a.contacts[0].force_base_N) - b.contacts[0].force_base_N), 1e-6);
    }
    EXPECT_GT(rest.output.contact_count, 0);
  }
}

TEST(PlacedScene, IdentityPlacementIsBitIdenticalToStep) {
  Random random(502);
  PlacedPen placed(SceneOf(Sphere(8, 0.02))), plain(SceneOf(Sphere(8, 0.02)));
  Vec3 tip{0, 0, 0.025};
  for (int k = 0; k < 500; ++k) {
    tip = 0.99 * tip + 0.0004 * random.InBox(1);
    placed.MoveTo(tip, {});
    plain.input = placed.input;
    Step(plain.config, plain.scene, plain.input, plain.state, plain.output);
    ASSERT_TRUE(support::SameBits(plain.output.force_base_N, placed.output.force_base_N)) << k;
  }
}

// Carried along with its pen, a scene is at rest for it: the press stays as it is, and nothing rubs or damps.
TEST(PlacedScene, PenMovingWithTheSceneGetsNoFrictionOrDamping) {
  Material rough;
  rough.static_friction = rough.dynamic_friction = 0.5;
  rough.damping_Ns_m = 2;
  PlacedPen pen(SceneOf(Block(4, {0.02, 0.02, 0.01}), rough));
  Placement placement;
  for (int k = 0; k <= 310; ++k) pen.MoveTo({0, 0, 0.012 - 1e-5 * std::min(k, 300)}, placement);
  const double pressed_N = pen.output.force_base_N.z;
  ASSERT_GT(pressed_N, 0.3);
  for (int k = 1; k <= 400; ++k) {  // 0.2 m/s sideways and up, turning
    placement.rotation = QuarterAbout({0, 0, 1}, 2e-3 * k);
    placement.translation_m = {2e-4 * k, 0, 1e-4 * k};
    const Frame frame{false, placement.rotation, placement.translation_m};
    pen.MoveTo(frame.ToBase({0, 0, 0.009}), placement);
    ASSERT_NEAR(Norm(pen.output.force_base_N), pressed_N, 0.02 * pressed_N) << k;
  }
}

// A scene that moves under a resting pen drags it by its friction, as a moved object does.
TEST(PlacedScene, SlidingSceneDragsARestingPenByFriction) {
  Material rough;
  rough.static_friction = rough.dynamic_friction = 0.3;
  PlacedPen pen(SceneOf(Block(4, {0.2, 0.05, 0.01}), rough));
  Placement placement;
  for (int k = 0; k <= 300; ++k) pen.MoveTo({0, 0, 0.012 - 1e-5 * k}, placement);
  for (int k = 0; k < 200; ++k) {
    placement.translation_m.x += 1e-4;
    pen.MoveTo({0, 0, 0.009}, placement);
  }
  EXPECT_NEAR(pen.output.force_base_N.x, 0.3 * 0.4, 2e-3);
  ASSERT_EQ(pen.output.contact_count, 1);
  EXPECT_NEAR(pen.output.contacts[0].slip_base_m_s.x, -0.1, 1e-3);
}

// Wherever it jumps, and however it is turned there: no tick changes the force by more than a fade does, far below the
// slew limit.
TEST(PlacedScene, TeleportedSceneDoesNotKick) {
  Random random(503);
  double largest_N = 0;
  for (int trial = 0; trial < 50; ++trial) {
    PlacedPen pen(SceneOf(Block(2, {0.01, 0.01, 0.01}), Frictionless()));
    for (int k = 0; k < 400; ++k) pen.MoveTo({0, 0, 0.012 - 1e-5 * k}, {});
    ASSERT_GT(pen.output.force_base_N.z, 0.7);
    pen.step_N = 0;
    const Placement there{QuarterAbout(random.InBox(1), random.Uniform(0, 3)),
                          random.Uniform(0, 1) < 0.5 ? 0.003 * random.InBox(1) : random.InBox(0.3)};
    pen.MoveTo({0, 0, 0.00801}, there, true);
    for (int k = 0; k < 100; ++k) pen.MoveTo({0, 0, 0.00801}, there);
    largest_N = std::max(largest_N, pen.step_N);
    const Frame frame{false, there.rotation, there.translation_m};
    const Vec3 in_scene = frame.ToRest({0, 0, 0.00801});
    const bool inside = std::abs(in_scene.x) < 0.01 && std::abs(in_scene.y) < 0.01 && std::abs(in_scene.z) < 0.01;
    EXPECT_EQ(pen.output.contact_count, inside ? 1 : 0) << trial;
    if (!inside) {
      EXPECT_EQ(pen.output.force_base_N, Vec3{}) << trial;
    }
  }
  EXPECT_LT(largest_N, 0.2) << "the slew limit is 0.85";
  RecordProperty("largest_step_mN", static_cast<int>(1e3 * largest_N));
  std::printf("[ figure   ] a leap of a scene that is pressed with 0.8 N: largest change within a tick %.3f N\n",
              largest_N);
}

// What the coils can do is the base's: a scene that is turned gets no more than they give in that direction.
TEST(PlacedScene, ForceLimitStaysInTheBaseFrame) {
  Random random(505);
  int cut = 0;
  for (int trial = 0; trial < 20; ++trial) {
    PlacedPen pen(SceneOf(Sphere(8, 0.02), Frictionless()));
    pen.input.limit.ampere_per_newton = {40, 0, 0, 0, 5, 0, 0, 0, 15};
    if (trial % 2 == 0) {  // coils that are short of power, and a core that pulls hard
      pen.input.limit.resistance_ohm = {0.5, 2, 1};
      pen.input.limit.power_max_W = 20;
      pen.input.limit.bias_A = {0.3, -0.5, 1};
      pen.input.limit.bias_fade_N = 0.5;
      pen.input.limit.snapping_N = {0.1, 0.2, -0.4};
      pen.input.limit.force_max_N = 0.45;
    }
    const Placement placement{QuarterAbout(random.InBox(1), random.Uniform(0, 3)), {}};
    const Vec3 out = Normalized(random.InBox(1));
    for (int k = 0; k < 300; ++k) {
      pen.MoveTo((0.022 - 2e-5 * k) * out, placement);
      ASSERT_GE(base::FeasibleScale(pen.input.limit, pen.output.force_base_N), 1 - 1e-9);
      cut += pen.output.saturated;
    }
  }
  EXPECT_GT(cut, 100);
}

TEST(PlacedScene, InvalidPlacementsAreIgnored) {
  const double nan = std::nan("");
  PlacedPen with(SceneOf(Block(2, {0.01, 0.01, 0.01}))), without(SceneOf(Block(2, {0.01, 0.01, 0.01})));
  const Placement bad[] = {
      {{nan, 0, 0, 0}, {}}, {{0, 0, 0, 0}, {}}, {{2, 0, 0, 0}, {}}, {{}, {nan, 0, 0}}, {{}, {0, 1e30, 0}}};
  for (int k = 0; k < 300; ++k) {
    const Vec3 tip{0, 0, 0.012 - 1e-5 * k};
    with.MoveTo(tip, bad[k % 5]);
    without.MoveTo(tip, {});
    ASSERT_TRUE(support::SameBits(with.output.force_base_N, without.output.force_base_N)) << k;
  }
}

TEST(PlacedScene, DoesNotAllocate) {
  PlacedPen pen(SceneOf(Sphere(8, 0.02)));
  const MaterialChange change{0, base::ParametersOf(Frictionless())};
  pen.input.materials = {&change, 1};
  const loop::AllocProbe probe;
  for (int k = 0; k < 1000; ++k) {
    pen.MoveTo({0, 0, 0.0195}, {QuarterAbout({0, 0, 1}, 1e-3 * k), {1e-6 * k, 0, 0}}, k % 100 == 0);
  }
  EXPECT_EQ(probe.count(), 0U);
}

// From any parameters to any others under a pressing, sliding pen: the force changes smoothly over the glide, and
// arrives.
TEST(LiveMaterial, ChangeDuringContactIsContinuous) {
  Random random(504);
  double largest_N = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Material material;
    material.stiffness_N_m = 400;
    material.static_friction = material.dynamic_friction = 0.5;
    PlacedPen pen(SceneOf(Block(4, {0.05, 0.05, 0.01}), material));
    double x_m = 0;
    for (int k = 0; k < 400; ++k) pen.MoveTo({x_m, 0, 0.0125 - 1e-5 * std::min(k, 300)}, {});
    MaterialChange change{0, base::ParametersOf(material)};
    change.parameters.stiffness_N_m = random.Uniform(0, 900);
    change.parameters.damping_Ns_m = random.Uniform(0, 2);
    change.parameters.static_friction = random.Uniform(0, 1.5);
    change.parameters.dynamic_friction = change.parameters.static_friction;  // a stick that slips is a step of its own
    change.parameters.viscosity_Ns_m = random.Uniform(0, 2);
    change.parameters.vibration_amplitude_N = random.Uniform(0, 0.03);
    change.parameters.vibration_frequency_Hz = random.Uniform(20, 120);
    pen.input.materials = {&change, 1};
    pen.step_N = 0;
    for (int k = 0; k < 300; ++k) {
      x_m += 2e-5;
      pen.MoveTo({x_m, 0, 0.0095}, {});
    }
    largest_N = std::max(largest_N, pen.step_N);
    const double expected_N = std::min(change.parameters.stiffness_N_m, pen.output.stiffness_offered_N_m) * 0.0005;
    ASSERT_EQ(pen.output.contact_count, 1);
    EXPECT_NEAR(pen.output.contacts[0].normal_force_N, expected_N, 0.05 * expected_N + 1e-4) << trial;
  }
  // The hum alone changes by up to 2 pi f A a tick.
  EXPECT_LT(largest_N, 0.06);
  std::printf("[ figure   ] a material changed under the pen: largest change of force within a tick %.4f N\n",
              largest_N);
}

TEST(LiveMaterial, RevertsToTheSceneMaterialWhenRemoved) {
  PlacedPen pen(SceneOf(Block(4, {0.05, 0.05, 0.01}), Frictionless()));
  MaterialChange change{0, base::ParametersOf(Frictionless())};
  change.parameters.stiffness_N_m = 100;
  pen.input.materials = {&change, 1};
  for (int k = 0; k < 700; ++k) pen.MoveTo({0, 0, 0.012 - 7e-6 * std::min(k, 400)}, {});
  EXPECT_NEAR(pen.output.force_base_N.z, 100 * 0.0008, 1e-3);
  pen.input.materials = {};
  for (int k = 0; k < 400; ++k) pen.MoveTo({0, 0, 0.0092}, {});
  EXPECT_NEAR(pen.output.force_base_N.z, 400 * 0.0008, 1e-3);
}

TEST(LiveMaterial, NonFiniteValuesAndUnknownMaterialsAreIgnored) {
  const double nan = std::nan("");
  PlacedPen with(SceneOf(Block(4, {0.05, 0.05, 0.01}))), without(SceneOf(Block(4, {0.05, 0.05, 0.01})));
  MaterialChange changes[] = {{0, base::ParametersOf(Material{})}, {7, {}}, {kNoIndex, {}}};
  changes[0].parameters.stiffness_N_m = nan;
  changes[0].parameters.static_friction = nan;
  with.input.materials = changes;
  for (int k = 0; k < 400; ++k) {
    const Vec3 tip{1e-5 * k, 0, 0.012 - 1e-5 * k};
    with.MoveTo(tip, {});
    without.MoveTo(tip, {});
    ASSERT_TRUE(support::SameBits(with.output.force_base_N, without.output.force_base_N)) << k;
  }
}

}  // namespace test_haptics_placed
}  // namespace omni::haptics
