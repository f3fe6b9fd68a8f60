// A ball tip through the whole of Step, which keeps its place from tick to tick or starts it again: the centre is never
// inside of a body, and the force never draws the tip inwards. Judged by winding numbers.
#include <gtest/gtest.h>

#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"
#include "tests/deformable/scenario.h"
#include "tests/support/surface_queries.h"
#include "tests/support/touch/ball_bodies.h"
#include "tests/support/touch/ball_judge.h"

namespace omni::haptics {
namespace test_haptics_ball_step {

constexpr double kNearest = -2.5 * kBallMargin;  // docs/theory/haptics.md (12.7), with room for rounding

std::vector<Corners> CornersOf(const Scene& scene, std::uint32_t object) {
  return CornersOf(Surface(scene, {}), scene.objects()[object]);
}

TEST(BallInStep, StaysOutsideWhileSlidingOverBodies) {
  std::uint64_t seed = 31'000;
  for (const BallBody& body : BallBodies()) {
    for (const double radius_m : {0.0005, 0.0015, 0.003}) {
      const BallVerdict verdict = SlideOver(Turned(body.object, {2, -1, 3}, 0.3), radius_m, 3000, ++seed);
      EXPECT_EQ(verdict.inside, 0U) << body.name << " " << radius_m;
      EXPECT_EQ(verdict.inverted, 0U) << body.name << " " << radius_m;
      EXPECT_GT(verdict.least_gap, kNearest) << body.name << " " << radius_m;
      EXPECT_GT(verdict.judged, 1000U) << body.name << " " << radius_m;
    }
  }
}

// Around the edges of twelve triangles a tick's moves are used up now and then while the ball has left the rim.
TEST(BallInStep, ContinuesAfterATickRunsOutOfMoves) {
  constexpr double kRadius_m = 0.0005;
  const InputObject cube = Turned(Block(1, {0.012, 0.012, 0.012}), {1, 2, 3}, 0.7);
  const Scene scene = Built(BallScene(cube, kRadius_m));
  BallVerdict sum;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Pen pen(scene);
    SlidingHand hand(scene, kRadius_m, seed, {.step_m = 1e-4, .press_m = 8e-4});
    BallJudge judge(CornersOf(scene, 0), kRadius_m);
    for (int k = 0; k < 30'000; ++k) {
      const Vec3 tip = hand.Next();
      pen.MoveTo(tip);
      judge.Judge(tip, pen.state, pen.output);
    }
    sum.Add(judge.verdict);
  }
  EXPECT_EQ(sum.inside, 0U) << sum.falls << " falls";
  EXPECT_EQ(sum.inverted, 0U);
}

// A tip that moves further in a tick than the ball can roll over a fine mesh: until the ball has caught up, there is no
// force without a touch.
TEST(BallInStep, NoForceWhileTheBallCatchesUpThroughFreeSpace) {
  constexpr double kRadius_m = 0.003;
  const Scene scene = Built(BallScene(sculpt::BumpyBall(60, 0.02, 0.12), kRadius_m));
  const Surface surface(scene, {});
  Pen pen(scene);
  Random random(32'001);
  Vec3 tip{0, 0, 0.05}, goal = tip;
  int in_flight = 0;
  for (int k = 0; k < 6000; ++k) {
    constexpr double kStep_m = 0.009;
    if (Norm(goal - tip) < kStep_m) goal = random.Uniform(0.018, 0.04) * Normalized(random.InBox(1));
    tip = tip + std::min(kStep_m, Norm(goal - tip)) * Normalized(goal - tip);
    pen.MoveTo(tip);
    const ContactState* contact = ContactWith(0, pen.state);
    if (contact == nullptr) continue;
    in_flight += contact->in_flight;
    const double distance_m =
        std::sqrt(support::NearestPoint(surface, scene.objects()[0], contact->held_m).closest.distance_squared);
    ASSERT_GT(distance_m / kRadius_m - 1, kNearest) << k;
    ASSERT_EQ(pen.output.contact_count, contact->in_flight ? 0 : 1) << k;
    ASSERT_TRUE(contact->in_flight || distance_m / kRadius_m - 1 < kBallMargin) << k;
  }
  EXPECT_GT(in_flight, 20);
}

// Wherever the tip is when a scene comes, and when the pen comes back.
TEST(BallInStep, StartsOutsideAfterSwapOrTrackingLoss) {
  Random random(32'002);
  for (const BallBody& body : BallBodies()) {
    for (const double radius_m : {0.0005, 0.003}) {
      const Scene scene = Built(BallScene(body.object, radius_m));
      Pen pen(scene);
      BallJudge judge(CornersOf(scene, 0), radius_m);
      for (int k = 0; k < 60; ++k) {
        if (k % 2 == 0) pen.Swap(scene);
        for (int lost = 0; lost < 30 && k % 2 == 1; ++lost) pen.Lose();
        const Vec3 tip = random.InBox(0.012);
        for (int rest = 0; rest < 5; ++rest) {
          pen.MoveTo(tip);
          judge.Judge(tip, pen.state, pen.output);
        }
      }
      EXPECT_EQ(judge.verdict.inside, 0U) << body.name;
      EXPECT_EQ(judge.verdict.inverted, 0U) << body.name;
      EXPECT_GT(judge.verdict.judged, 5U) << body.name;
    }
  }
}

base::Quat Turn(const Vec3& axis, double angle_rad) {
  const Vec3 v = std::sin(angle_rad / 2) * Normalized(axis);
  return {std::cos(angle_rad / 2), v.x, v.y, v.z};
}

// The application moves and turns a body about a hand, over it while the pen is not seen, and puts it elsewhere.
TEST(BallInStep, StaysOutsideAMovingBody) {
  for (const BallBody& body : BallBodies()) {
    constexpr double kRadius_m = 0.0008;
    SceneInput input = BallScene(body.object, kRadius_m);
    input.objects[0].kinematic = true;
    Pen pen(Built(input));
    SlidingHand hand(pen.scene(), kRadius_m, 32'003);
    BallJudge judge(CornersOf(pen.scene(), 0), kRadius_m);
    Random random(32'003);
    ObjectPose pose{.object = 0};
    pen.input.poses = {&pose, 1};
    for (int k = 0; k < 4000; ++k) {
      const Vec3 tip = hand.Next();
      pose.leaps = k % 500 == 499;
      const double t_s = 1e-3 * k + (pose.leaps ? random.Uniform(0, 10) : 0);
      pose.translation_m = {0.004 * std::sin(9 * t_s), 0.004 * std::sin(11 * t_s), 0.004 * std::sin(7 * t_s)};
      pose.rotation = Turn({1, 2, 3}, 0.3 * std::sin(5 * t_s));
      if (k % 150 > 130) {
        pen.Lose();
        continue;
      }
      pen.MoveTo(tip);
      judge.Judge(tip, pen.state, pen.output, {false, pose.rotation, pose.translation_m});
    }
    EXPECT_EQ(judge.verdict.inside, 0U) << body.name;
    EXPECT_EQ(judge.verdict.inverted, 0U) << body.name;
    EXPECT_GT(judge.verdict.judged, 500U) << body.name;
  }
}

// Bodies that touch each other, two, and more than there are slots: the ball rolls over each by itself.
TEST(BallInStep, StaysOutsideSeveralBodies) {
  constexpr double kRadius_m = 0.001;
  for (const int count : {2, 7}) {
    SceneInput input = BallScene(Block(1, {0.012, 0.012, 0.012}), kRadius_m);
    Random random(32'004);
    for (int n = 1; n < count; ++n) {
      const Vec3 aside = count == 2 ? Vec3{0.024, 0, -0.006} : random.InBox(0.004);
      input.objects.push_back(Block(n % 2 == 0 ? 1 : 4, {0.012, 0.012, 0.012}, aside));
    }
    Pen pen(Built(input));
    SlidingHand hand(pen.scene(), kRadius_m, 32'004);
    std::vector<BallJudge> judges;
    for (std::uint32_t n = 0; n < input.objects.size(); ++n)
      judges.emplace_back(CornersOf(pen.scene(), n), kRadius_m, n);
    std::uint64_t touching = 0, inside = 0, inverted = 0, without = 0;
    for (int k = 0; k < 15'000; ++k) {
      const Vec3 tip = hand.Next();
      pen.MoveTo(tip);
      for (std::uint32_t n = 0; n < judges.size(); ++n) {
        const bool is_left_out = count > kMaxContacts && ContactWith(n, pen.state) == nullptr;
        without += is_left_out;
        if (!is_left_out) judges[n].Judge(tip, pen.state, pen.output);
      }
    }
    for (const BallJudge& judge : judges) {
      touching += judge.verdict.judged;
      inside += judge.verdict.inside;
      inverted += judge.verdict.inverted;
    }
    EXPECT_EQ(inside, 0U) << count;
    EXPECT_EQ(inverted, 0U) << count;
    EXPECT_GT(touching, 10'000U) << count;
    EXPECT_EQ(without > 0, count > kMaxContacts);
  }
}

// A face is pushed out from under a small ball, which touches it or hovers, by more than its size in a tick.
TEST(BallInStep, StaysOutsideAnExtrudedFaceThatPassesIt) {
  constexpr double kRadius_m = 1e-4, kTop_m = 0.01, kWay_m = 4e-4;
  for (const double height_m : {-5e-5, 5e-5}) {
    for (const bool is_seen : {true, false}) {
      SceneInput input = BallScene(Block(4, {0.02, 0.02, kTop_m}), kRadius_m);
      input.materials[0].extrude.enabled = true;
      Pen pen(Built(input));
      std::size_t top = 0;
      while (!(pen.scene().regions()[top].normal.z > 0.9)) ++top;
      const Vec3 tip{0.003, -0.002, kTop_m + kRadius_m + height_m};
      pen.MoveTo(tip + Vec3{0, 0, 0.001});
      pen.MoveTo(tip);
      pen.state.regions[top].offset_m += kWay_m;
      if (!is_seen) pen.Lose();
      pen.MoveTo(tip);
      const ContactState* contact = ContactWith(0, pen.state);
      ASSERT_NE(contact, nullptr) << height_m << " " << is_seen;
      EXPECT_NEAR(contact->held_m.z, kTop_m + kWay_m + kRadius_m, 1e-2 * kRadius_m) << height_m << " " << is_seen;
    }
  }
}

std::vector<Corners> CornersOf(const Mesh& mesh) {
  std::vector<Corners> corners;
  for (const auto& [a, b, c] : mesh.triangles)
    corners.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
  return corners;
}

// The surface is pulled over a ball that touches or hovers, by more than its size and at once, and let back.
TEST(BallInStep, StaysOutsideASurfaceSculptedOverIt) {
  using namespace sculpt;
  constexpr double kRadius_m = 0.001;
  Scene scene = Built(BallScene(Sphere(16, 0.02), kRadius_m));
  auto live = std::make_shared<LiveParts>();
  auto sculpt_session =
      std::make_unique<SculptSession>(EditorOf(Sphere(16, 0.02)), SculptParameters{.grab_force_N = 2}, Brush{});
  SculptEditor& editor = sculpt_session->editor();
  sculpt_session->SetReader(true);
  live->AddSculptSession(0, std::move(sculpt_session));
  scene.SetLive(std::move(live));
  Pen pen(std::move(scene));
  Random random(32'005);
  std::uint64_t inside = 0, felt = 0;
  for (int round = 0; round < 60; ++round) {
    const Vec3 n = Normalized(random.InBox(1));
    const double height_m = round % 2 == 0 ? -3e-4 : 1e-3;
    pen.MoveTo(0.03 * n);
    pen.Slide(0.03 * n, (0.02 + kRadius_m + height_m) * n, 40);
    for (const bool pulls : {true, false}) {
      ASSERT_TRUE(pulls ? editor.Stroke(On(editor, 0.02 * n), Brush{}, 0.004).ok() : editor.Undo());
      editor.Publish();
      const bool unseen = round % 3 == 2;  // it happens while the pen is not seen
      if (unseen) pen.Lose();
      BallOracle oracle(CornersOf(editor.Snapshot()));
      for (int k = 0; k < 30; ++k) {
        pen.Rest(1);
        const ContactState* contact = ContactWith(0, pen.state);
        inside += oracle.IsInside(contact != nullptr ? contact->held_m : pen.state.last_device_point_base_m);
        felt += pen.output.contact_count > 0;
      }
    }
    pen.MoveTo(0.03 * n);
  }
  EXPECT_EQ(inside, 0U);
  EXPECT_GT(felt, 1000U);
}

// A soft body deforms under the ball, whose place is kept on the body at rest.
TEST(BallInStep, StaysOutsideTheRestShapeOfASoftBody) {
  for (const double radius_m : {0.0005, 0.002}) {
    SceneInput input = BallScene(SoftBallMesh(), radius_m);
    input.materials[0].softness = {.model = SoftnessModel::kTet, .young_modulus_Pa = kSoftModulus_Pa};
    Scene scene = Built(input);
    auto live = std::make_shared<LiveParts>();
    live->SetSoftBody(0, std::make_unique<const SoftBody>(SoftBall()));
    scene.SetLive(std::move(live));
    Pen pen(std::move(scene));
    SlidingHand hand(pen.scene(), radius_m, 32'006);
    BallOracle oracle(CornersOf(pen.scene(), 0));
    std::uint64_t inside = 0, inverted = 0, felt = 0;
    for (int k = 0; k < 8000; ++k) {
      const Vec3 tip = hand.Next();
      pen.MoveTo(tip);
      const ContactState* contact = ContactWith(0, pen.state);
      const Vec3 centre = contact != nullptr ? contact->held_m : tip;
      inside += oracle.IsInside(centre);
      if (pen.output.contact_count == 0 || contact == nullptr || contact->swap_left_s > 0) continue;
      ++felt;
      inverted += Dot(pen.output.contacts[0].force_base_N, centre - tip) < -1e-6;
    }
    EXPECT_EQ(inside, 0U) << radius_m;
    EXPECT_EQ(inverted, 0U) << radius_m;
    EXPECT_GT(felt, 3000U) << radius_m;
  }
}

}  // namespace test_haptics_ball_step
}  // namespace omni::haptics
