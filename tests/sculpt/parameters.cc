// Pressing, holding, pulling and letting go, on a real surface that is edited and published meanwhile.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "service/haptics/sculpt/sculpt_query.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/touch/sculpt_hand.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_parameters {

constexpr double kRadius_m = 0.03;
constexpr double kSlew_N = 0.85;  // per tick

Brush FiveMillimetres() {
  Brush brush;
  brush.radius_m = 0.005;
  return brush;
}

// Height of the surface on the z axis, seen from above.
double TopOf(SculptEditor& editor) {
  editor.Publish();
  const Vec3 above{0, 0, 2 * kRadius_m};
  const CrossingResult hit = CrossingInTree(SculptSurface(*editor.publisher().newest()), 0, above, {}, false);
  return hit.triangle == kNoIndex ? 0 : (1 - hit.t) * above.z;
}

// Comes from above, presses by `depth_m` and stays for the dwell.
void Grab(SculptHand& hand, double top_m, double depth_m = 0.0015) {
  hand.MoveTo({0, 0, top_m + 0.005});
  hand.Go({0, 0, top_m - depth_m}, 0.03);
  hand.Rest(250);
}

// A hand that opens goes with the force until there is little, and stays.
void Open(SculptHand& hand) {
  for (int k = 0; k < 2000 && std::abs(hand.force_N().z) > 0.1; ++k) {
    hand.MoveTo(hand.tip() + Vec3{0, 0, std::copysign(1e-5, hand.force_N().z)});
  }
  hand.Rest(700);
}

TEST(SculptParametersTest, PullingOutMakesABump) {
  SculptHand hand(Sphere(40, kRadius_m), {}, FiveMillimetres());
  SculptEditor& editor = hand.editor();
  const double top_m = TopOf(editor);
  Grab(hand, top_m);
  ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
  hand.Go({0, 0, top_m + 0.006}, 0.03);
  EXPECT_LT(hand.force_N().z, -0.2);  // it resists the pull
  EXPECT_GT(hand.state().offset_m, 0.003);
  hand.Rest(2000);
  EXPECT_EQ(hand.state().phase, SculptPhase::kHeld);  // it is pulled
  Open(hand);
  EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
  EXPECT_FALSE(editor.in_stroke());
  EXPECT_EQ(editor.undo_steps(), 1U);
  EXPECT_NEAR(TopOf(editor) - top_m, hand.state().offset_m, 2e-4);
  EXPECT_LT(hand.largest_step_N(), kSlew_N / 4);
  // Sliding across at a height that was in the open is now pushed up by the bump.
  hand.Go({0.02, 0, top_m + 0.004}, 0.1);
  hand.Go({0.02, 0, top_m + 0.001}, 0.1);
  double felt_N = 0;
  for (double x = 0.02; x > 0; x -= 1e-4) felt_N = std::max(felt_N, hand.MoveTo({x, 0, top_m + 0.001}).x);
  EXPECT_GT(felt_N, 0.1);  // against the motion
}

TEST(SculptParametersTest, PushesInOnlyBeyondTheYieldForce) {
  SculptParameters parameters;
  SculptHand hand(Sphere(40, kRadius_m), parameters, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
  const double depth_m = 0.0015, bears_m = parameters.yield_N / parameters.stiffness_N_m;
  hand.Go({0, 0, top_m - depth_m - 0.9 * bears_m}, 0.01);
  EXPECT_EQ(hand.state().offset_m, 0);
  hand.Go({0, 0, top_m - depth_m - 0.005}, 0.03);
  EXPECT_LT(hand.state().offset_m, -0.002);
  hand.Rest(400);
  EXPECT_LT(TopOf(hand.editor()), top_m - 0.002);
  EXPECT_LT(hand.largest_step_N(), kSlew_N / 4);
}

TEST(SculptParametersTest, ResistanceGrowsWithSpeedAndTravel) {
  const auto pull = [](double speed_m_s, double way_m) {
    SculptHand hand(Sphere(20, kRadius_m), {}, FiveMillimetres());
    const double top_m = TopOf(hand.editor());
    Grab(hand, top_m);
    hand.Go({0, 0, top_m + way_m}, speed_m_s);
    return -hand.force_N().z;
  };
  EXPECT_GT(pull(0.06, 0.006), pull(0.02, 0.006) + 0.1);
  EXPECT_GT(pull(0.03, 0.012), pull(0.03, 0.006) + 0.1);
}

// The worst case: undo while the pen is inside what was pulled out or pushed in.
TEST(SculptParametersTest, UndoDuringContactDoesNotKick) {
  for (const double offset_m : {-0.004, 0.004}) {
    SculptHand hand(Sphere(40, kRadius_m), {.grab_force_N = 2}, FiveMillimetres());
    SculptEditor& editor = hand.editor();
    ASSERT_TRUE(editor.Stroke(On(editor, {0, 0, 1}), FiveMillimetres(), offset_m).ok());
    editor.Publish();
    hand.MoveTo({0, 0, TopOf(editor) + 0.002});
    hand.Go({0, 0, TopOf(editor) - 0.001}, 0.03);
    hand.ForgetSteps();
    ASSERT_TRUE(editor.Undo());
    hand.Rest(100);
    EXPECT_LT(hand.largest_step_N(), 0.15) << offset_m;
    EXPECT_NEAR(TopOf(editor), kRadius_m, 1e-5) << offset_m;
    if (offset_m < 0) {
      EXPECT_NEAR(hand.force_N().z, 0.005 * SculptHand::kStiffness_N_m, 0.1);
    } else {
      EXPECT_EQ(hand.force_N(), Vec3{});
    }
  }
}

TEST(SculptParametersTest, SettlesOnTheGrid) {
  SculptOptions options;
  options.grid_step_m = 0.002;
  SculptHand hand(Sphere(40, kRadius_m), {.grid_step_m = options.grid_step_m}, FiveMillimetres(), options);
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  hand.Go({0, 0, top_m + 0.006}, 0.03);
  Open(hand);
  hand.Rest(200);
  const double steps = hand.state().offset_m / options.grid_step_m;
  EXPECT_GE(steps, 1);
  EXPECT_NEAR(steps, std::round(steps), 1e-9);
  EXPECT_NEAR(TopOf(hand.editor()) - top_m, hand.state().offset_m, 2e-5);
}

TEST(SculptParametersTest, ReleasesATipAtRestDespiteNoise) {
  SculptHand hand(Sphere(20, kRadius_m), {}, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  hand.Go({0, 0, top_m + 0.006}, 0.03);
  ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
  Random random(9);
  const double rest_m = top_m - 0.0015 + hand.state().offset_m + hand.state().start_force_N / 400;
  for (int k = 0; k < 900; ++k) hand.MoveTo({0, 0, rest_m + random.Uniform(-6e-4, 6e-4)});  // of 1 ms each
  EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
}

TEST(SculptParametersTest, ReleasesAHandThatTrembles) {
  SculptHand hand(Sphere(20, kRadius_m), {}, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  hand.Go({0, 0, top_m + 0.006}, 0.03);
  ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
  const double rest_m = top_m - 0.0015 + hand.state().offset_m + hand.state().start_force_N / 400;
  for (int k = 0; k < 1500; ++k) hand.MoveTo({0, 0, rest_m + 7e-4 * std::sin(2 * std::numbers::pi * 0.005 * k)});
  EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
}

// Also between press and pull, where there is no force.
TEST(SculptParametersTest, HoldsATipThatMovesSlowly) {
  SculptHand hand(Sphere(40, kRadius_m), {}, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  hand.Go({0, 0, top_m - 0.004}, 0.03);
  hand.Go({0, 0, top_m + 0.006}, 0.003);
  EXPECT_EQ(hand.state().phase, SculptPhase::kHeld);
  EXPECT_GT(hand.state().offset_m, 0.003);
}

// Fine work takes its time: from the press through the point without force to the pull.
TEST(SculptParametersTest, HoldsATipThatMovesAMillimetreInASecond) {
  for (const double speed_m_s : {0.001, 0.002, 0.006}) {
    SculptHand hand(Sphere(40, kRadius_m), {.hardening_N_m = 20}, FiveMillimetres());
    const double top_m = TopOf(hand.editor());
    Grab(hand, top_m);
    Random random(4);
    const double from_m = hand.tip().z;
    Vec3 shake;  // .1 mm, alike for 7 ms, as tracked poses have
    for (double z_m = from_m; z_m < from_m + 0.015; z_m += 1e-3 * speed_m_s) {
      shake = 0.87 * shake + random.InBox(9e-5);
      hand.MoveTo({shake.x, shake.y, z_m + shake.z});
      ASSERT_EQ(hand.state().phase, SculptPhase::kHeld) << speed_m_s << " " << 1e3 * (z_m - from_m);
    }
    EXPECT_GT(hand.state().offset_m, 0.010) << speed_m_s;
    hand.Rest(5000);
    EXPECT_EQ(hand.state().phase, SculptPhase::kHeld);
    EXPECT_NEAR(hand.force_N().z, -0.2 - 20 * hand.state().offset_m, 0.03) << speed_m_s;
  }
}

TEST(SculptParametersTest, NeverLetsGoOfATipAtRestWhereTheMaterialSaysSo) {
  SculptHand hand(Sphere(40, kRadius_m), {.rest_s = 0}, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  hand.Go({0, 0, top_m + 0.006}, 0.03);
  Open(hand);
  hand.Rest(5000);
  EXPECT_EQ(hand.state().phase, SculptPhase::kHeld);
  hand.Go({0, 0, top_m + 0.05}, 0.5);  // pulled away
  hand.Rest(100);
  EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
  EXPECT_EQ(hand.editor().undo_steps(), 1U);
}

// By a key or a button, also in the middle of a pull; it then holds again only after the pen has let off.
TEST(SculptParametersTest, ReleasesWhenAUserAsks) {
  SculptHand hand(Sphere(40, kRadius_m), {.rest_s = 0}, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  hand.Release();  // of nothing
  Grab(hand, top_m);
  hand.Go({0, 0, top_m + 0.006}, 0.03);
  ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
  const double bump_m = hand.state().offset_m;
  ASSERT_GT(bump_m, 0.003);
  hand.Release();
  hand.Rest(30);
  EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
  EXPECT_EQ(hand.state().hold, 0);
  EXPECT_EQ(hand.editor().undo_steps(), 1U);
  EXPECT_NEAR(TopOf(hand.editor()) - top_m, bump_m, 2e-4);
  hand.MoveTo({0, 0, top_m + 0.03});
  Grab(hand, TopOf(hand.editor()));
  EXPECT_EQ(hand.state().phase, SculptPhase::kHeld) << "the last one is over";
}

// Below its yield force clay is a spring, pushed or pulled; who lets go after that has changed nothing.
TEST(SculptParametersTest, ProbingIsElasticBothWaysAndChangesNothing) {
  const SculptParameters parameters;
  SculptHand hand(Sphere(40, kRadius_m), parameters, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  const std::uint64_t before = hand.editor().mesh().Hash();
  Grab(hand, top_m);
  ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
  const double gripped_m = hand.tip().z, k_N_m = SculptHand::kStiffness_N_m;
  const double in_m = 0.9 * parameters.yield_N / k_N_m;
  const double out_m = (hand.state().start_force_N + 0.9 * parameters.yield_N) / k_N_m;
  for (int times = 0; times < 3; ++times) {
    hand.Go({0, 0, gripped_m - in_m}, 0.005);
    EXPECT_NEAR(hand.force_N().z, hand.state().start_force_N + k_N_m * in_m, 1e-3);
    hand.Go({0, 0, gripped_m + out_m}, 0.005);
    EXPECT_NEAR(hand.force_N().z, -0.9 * parameters.yield_N, 1e-3);
  }
  EXPECT_EQ(hand.state().offset_m, 0);
  Open(hand);
  EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
  hand.Go({0, 0, top_m + 0.01}, 0.02);
  hand.Rest(20);
  EXPECT_EQ(hand.editor().undo_steps(), 0U);
  EXPECT_EQ(hand.editor().mesh().Hash(), before);
}

// Press, wait, draw back: the surface comes along, however long the wait and however far the press went in.
TEST(SculptParametersTest, HoldsWhileItIsPressed) {
  SculptHand hand(Sphere(40, kRadius_m), {}, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  hand.Go({0, 0, top_m - 0.006}, 0.03);
  ASSERT_LT(hand.state().offset_m, -1e-3);
  hand.Rest(3000);
  EXPECT_EQ(hand.state().phase, SculptPhase::kHeld);
  hand.Go({0, 0, top_m + 0.008}, 0.05);
  EXPECT_GT(hand.state().offset_m, 0.004);
  EXPECT_EQ(hand.editor().undo_steps(), 0U);
}

TEST(SculptParametersTest, LeavesADentWhenTheHandOpens) {
  SculptHand hand(Sphere(40, kRadius_m), {}, FiveMillimetres());
  const double top_m = TopOf(hand.editor());
  Grab(hand, top_m);
  hand.Go({0, 0, top_m - 0.006}, 0.03);
  hand.Rest(400);
  const double dent_m = hand.state().offset_m;
  ASSERT_LT(dent_m, -1e-3);
  ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
  Open(hand);
  EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
  hand.Go({0, 0, top_m + 0.01}, 0.05);
  EXPECT_NEAR(TopOf(hand.editor()) - top_m, dent_m, 2e-4);
}

TEST(SculptParametersTest, TearingOrTrackingLossEndsTheStroke) {
  for (const bool torn : {true, false}) {
    SculptHand hand(Sphere(20, kRadius_m), {}, FiveMillimetres());
    const double top_m = TopOf(hand.editor());
    Grab(hand, top_m);
    ASSERT_EQ(hand.state().phase, SculptPhase::kHeld);
    if (torn) {
      hand.Go({0, 0, top_m + 0.03}, 1.0);
      hand.Rest(30);
    } else {
      for (int k = 0; k < 60; ++k) hand.Lose();
    }
    EXPECT_EQ(hand.state().phase, SculptPhase::kFree);
    EXPECT_EQ(hand.state().hold, 0);
    EXPECT_FALSE(hand.editor().in_stroke());
    EXPECT_TRUE(CheckManifold(hand.editor().mesh()).ok());
  }
}

// A base that is not calibrated allows little: the hold gets from the press to the pull with any stiffness.
TEST(SculptParametersTest, PullsEvenWithALowStiffnessBound) {
  for (const double stiffness_N_m : {30.0, 60.0, 120.0, 400.0}) {
    SculptToolState state;
    SculptInput input;
    input.tracked = true;
    input.dt_s = 1e-3;
    input.normal_stiffness_limit_N_m = stiffness_N_m;
    input.touch = {true, 0, {1, 0, 0}, {}, {0, 0, 1}, 0.6};
    StrokeRing ring;
    const auto step = [&] {
      StrokeMessage message;
      while (ring.TryPop(message)) {
      }
      return StepSculptTool({.tear_m = 0.002}, input, state, ring);
    };
    for (int k = 0; k < 300; ++k) step();
    ASSERT_EQ(state.phase, SculptPhase::kHeld);
    while (state.phase == SculptPhase::kHeld && input.tip_base_m.z < 0.06) {
      input.tip_base_m.z += 1.6e-5;
      if (step().force_N.z < -0.2 && state.offset_m > 1e-3) break;
    }
    EXPECT_EQ(state.phase, SculptPhase::kHeld) << stiffness_N_m;
    EXPECT_GT(state.offset_m, 1e-3) << stiffness_N_m;
    input.normal_stiffness_limit_N_m = 0;
    for (int k = 0; k < 50; ++k) step();
    EXPECT_NE(state.phase, SculptPhase::kHeld) << "nothing holds it";
    EXPECT_EQ(state.hold, 0);
  }
}

TEST(SculptParametersTest, StrokeMessagesAreDeferredWhileTheRingIsFull) {
  StrokeRing ring;
  while (ring.TryPush({})) {
  }
  SculptToolState state;
  SculptInput input;
  input.tracked = true;
  input.dt_s = 1e-3;
  input.stiffness_limit_N_m = input.normal_stiffness_limit_N_m = 400;
  input.touch = {true, 0, {1, 0, 0}, {}, {0, 0, 1}, 0.6};
  for (int k = 0; k < 300; ++k) StepSculptTool({}, input, state, ring);
  ASSERT_EQ(state.phase, SculptPhase::kHeld);
  for (int k = 0; k < 100; ++k) {
    input.tip_base_m.z += 1e-4;
    StepSculptTool({}, input, state, ring);
  }
  input.tracked = false;
  for (int k = 0; k < 100; ++k) StepSculptTool({}, input, state, ring);
  EXPECT_TRUE(state.begin_waits && state.end_waits);
  StrokeMessage message;
  while (ring.TryPop(message)) {
  }
  input.touch.touching = false;
  for (int k = 0; k < 10; ++k) StepSculptTool({}, input, state, ring);
  std::vector<StrokeKind> kinds;
  double offset_m = 0;
  while (ring.TryPop(message)) {
    kinds.push_back(message.kind);
    if (message.kind == StrokeKind::kMove) offset_m = message.offset_m;
  }
  EXPECT_EQ(kinds, (std::vector<StrokeKind>{StrokeKind::kBegin, StrokeKind::kMove, StrokeKind::kEnd}));
  EXPECT_EQ(offset_m, state.offset_m);
}

// Whatever comes in: finite, bounded, no heap.
TEST(SculptParametersTest, BadInputGivesFiniteForceWithoutAllocation) {
  const auto editor = EditorOf(BumpyBall(12, kRadius_m));
  const SculptTable* table = editor->publisher().Acquire();
  const double bad[] = {0, -1, 1e-9, 0.03, 1e3, 1e30, std::nan(""), std::numeric_limits<double>::infinity()};
  Random random(5);
  const auto any = [&] { return random.Next() % 3 == 0 ? bad[random.Next() % std::size(bad)] : random.Uniform(-1, 1); };
  const auto ring = std::make_unique<StrokeRing>();
  SculptToolState state;
  double largest_N = 0;
  bool finite = true;
  const loop::AllocProbe probe;
  for (int k = 0; k < 20000; ++k) {
    const SculptSurface surface(*table);
    SculptInput input;
    input.tracked = random.Next() % 8 != 0;
    input.tip_base_m = {any(), any(), any()};
    input.dt_s = any();
    input.stiffness_limit_N_m = any();
    input.normal_stiffness_limit_N_m = any();
    input.touch = {random.Next() % 2 == 0, 0, {}, {any(), any(), any()}, base::Normalized({any(), 1, 0}),
                   std::abs(any())};
    if (k % 1000 < 300) {  // long enough to take hold
      input.tracked = true;
      input.tip_base_m = {};
      input.dt_s = 1e-3;
      input.touch = {k % 1000 > 10, 0, {1, 0, 0}, {}, {0, 0, 1}, 0.6};
    }
    KeptFeature feature{0, {}, {any(), any(), any()}, {any(), any(), any()}};
    RebindFeature(surface, any(), feature);
    CrossingInTree(surface, 0, input.tip_base_m, {any(), any(), any()}, false);
    const SculptToolOutput out = StepSculptTool({}, input, state, *ring);
    finite = finite && IsWithin(out.force_N, 1e3) && out.contact_share >= 0 && out.contact_share <= 1;
    largest_N = std::max(largest_N, Norm(out.force_N));
    StrokeMessage message;
    while (ring->TryPop(message)) {
    }
  }
  EXPECT_EQ(probe.count(), 0U);
  EXPECT_TRUE(finite);
  EXPECT_GT(largest_N, 0);
  EXPECT_LT(largest_N, 2);
}

}  // namespace test_sculpt_parameters
}  // namespace omni::haptics::sculpt
