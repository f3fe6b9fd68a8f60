// A tip that is a ball, and force shading, in the tick.
#include <gtest/gtest.h>

#include "tests/haptics/scenario.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/touch/sculpt_hand.h"

namespace omni::haptics {
namespace test_haptics_ball {

constexpr double kBall_m = 0.003;

Material Slippery() {
  Material material;
  material.static_friction = material.dynamic_friction = 0;
  return material;
}

SceneInput WithBall(InputObject object, const Material& material = Slippery(), double radius_m = kBall_m) {
  SceneInput input = SceneOf(std::move(object), material);
  input.tip_radius_m = radius_m;
  return input;
}

// A trough along y: two walls that meet at x = 0, each at `half_angle` from the vertical.
InputObject Trough(double half_angle) {
  InputObject object;
  object.name = "trough";
  const double x = 0.03 * std::sin(half_angle), z = 0.03 * std::cos(half_angle);
  for (const double y : {-0.05, 0.05}) {
    for (const Vec3& p : {Vec3{-x, y, z}, Vec3{0, y, 0}, Vec3{x, y, z}}) object.vertices_base_m.push_back(p);
  }
  AddTriangle(object, 0, 1, 4);
  AddTriangle(object, 0, 4, 3);
  AddTriangle(object, 1, 2, 5);
  AddTriangle(object, 1, 5, 4);
  object.double_sided = true;
  return object;
}

TEST(BallTip, ContactStartsAtTheTipRadius) {
  for (const double radius_m : {0.0005, 0.003, 0.01}) {
    Pen pen(Built(WithBall(Block(8, {0.02, 0.02, 0.01}), Slippery(), radius_m)));
    pen.MoveTo({0.001, 0.002, 0.01 + radius_m + 0.002});
    pen.Slide({0.001, 0.002, 0.01 + radius_m + 0.002}, {0.001, 0.002, 0.01 + radius_m + 1e-5}, 50);
    EXPECT_EQ(pen.output.contact_count, 0);
    pen.Slide({0.001, 0.002, 0.01 + radius_m + 1e-5}, {0.001, 0.002, 0.01 + radius_m - 0.001}, 50);
    pen.Rest(5);
    ASSERT_EQ(pen.output.contact_count, 1);
    EXPECT_NEAR(pen.output.force_base_N.z, 0.4, 0.4 * 1e-3);
    EXPECT_NEAR(pen.output.contacts[0].point_base_m.z, 0.01, 1e-9);
    EXPECT_NEAR(pen.output.contacts[0].gap_m, -0.001, 2e-6);
  }
}

// The device point is the lowest point of the ball: an upright pen touches where its tip is seen to touch, and a
// leaning one with the side of its ball.
TEST(BallTip, TouchesWhereItIsSeenToTouch) {
  for (const double radius_m : {0.0005, 0.0015, 0.01}) {
    Pen pen(Built(WithBall(Block(8, {0.02, 0.02, 0.01}), Slippery(), radius_m)));
    pen.input.axis_base = {0, 0, -1};
    const auto put = [&](double height_m) { pen.MoveTo({0.001, 0.002, 0.01 + height_m}); };
    for (const double height_m : {0.002, 0.001, 1e-5}) put(height_m);
    EXPECT_EQ(pen.output.contact_count, 0) << radius_m;
    for (int k = 0; k < 50; ++k) put(-2e-5 * k);
    put(-0.001);
    ASSERT_EQ(pen.output.contact_count, 1) << radius_m;
    EXPECT_NEAR(pen.output.force_base_N.z, 0.4, 0.4 * 1e-3) << radius_m;
    EXPECT_NEAR(pen.output.contacts[0].point_base_m.z, 0.01, 1e-9);
  }
}

// Whatever the pen's lean and however it turns, all is as with a ball about the centre.
TEST(BallTip, CentreLiesOneRadiusUpThePen) {
  Random random(47);
  for (const double radius_m : {0.0005, 0.0015, 0.003}) {
    const Scene scene = Built(WithBall(sculpt::BumpyBall(10, 0.02, 0.1), Slippery(), radius_m));
    Pen leaning(scene), about(scene);
    const auto config = leaning.config;
    double largest_N = 0;
    Vec3 axis{0, 0, -1}, centre{0, 0, 0.03};
    for (int k = 0; k < 3000; ++k) {
      const Vec3 turned = Normalized(axis + random.InBox(0.02));
      const Vec3 rate_1_s = 1000 * (turned - axis);
      axis = turned;
      const Vec3 goal = (0.021 + radius_m - 0.002 * std::sin(0.01 * k)) *
                        base::Normalized({std::sin(0.003 * k), std::cos(0.004 * k), 1 + std::sin(0.005 * k)});
      const Vec3 moved = 0.1 * (goal - centre);
      centre = centre + moved;
      Output at_tip, at_centre;
      Input input = leaning.input;
      input.t_ns = std::int64_t{1'000'000} * k;
      input.device_point_base_m = centre;
      input.velocity_base_m_s = 1000 * moved;
      haptics::Step(config, scene, input, about.state, at_centre);
      input.axis_base = axis;
      input.axis_rate_base_1_s = rate_1_s;
      input.device_point_base_m = centre + radius_m * axis;
      input.velocity_base_m_s = 1000 * moved + radius_m * rate_1_s;
      haptics::Step(config, scene, input, leaning.state, at_tip);
      ASSERT_LT(Norm(at_tip.force_base_N - at_centre.force_base_N), 1e-6) << k;
      ASSERT_EQ(at_tip.contact_count, at_centre.contact_count) << k;
      largest_N = std::max(largest_N, Norm(at_tip.force_base_N));
    }
    EXPECT_GT(largest_N, 0.2);
  }
}

// A stick is led by the device point.
TEST(BallTip, StickFollowsTheDevicePoint) {
  SceneInput input = WithBall(Block(1, {0.005, 0.005, 0.005}));
  input.joystick = JoystickInput{.centre_base_m = {0, 0, 0.06}};
  Pen pen(Built(input));
  pen.input.axis_base = base::Normalized({1, 0, -1});
  pen.input.device_point_base_m = {0, 0, 0.06};
  for (int k = 0; k < 20; ++k) haptics::Step(pen.config, pen.scene(), pen.input, pen.state, pen.output);
  EXPECT_EQ(pen.output.thumbstick_x, 0);
  EXPECT_LT(Norm(pen.output.force_base_N), 1e-9);
}

// In a trough the ball rests on both walls: straight up, without ripple, whatever way it comes from.
TEST(BallTip, RestsOnBothWallsOfATrough) {
  for (const double half_angle : {0.3, 0.8, 1.2}) {
    Pen pen(Built(WithBall(Trough(half_angle))));
    const double rest_m = kBall_m / std::sin(half_angle);  // height of the centre
    pen.MoveTo({0.001, 0, rest_m + 0.01});
    pen.Slide({0.001, 0, rest_m + 0.01}, {0, 0, rest_m - 0.001}, 200);
    pen.Rest(20);
    ASSERT_EQ(pen.output.contact_count, 1);
    EXPECT_NEAR(pen.output.force_base_N.z, 0.4, 0.004) << half_angle;
    EXPECT_NEAR(pen.output.force_base_N.x, 0, 0.004) << half_angle;
    double largest_N = 0, least_N = 10;
    for (int k = 0; k < 200; ++k) {
      pen.MoveTo({1e-7 * std::sin(0.3 * k), 0, rest_m - 0.001});
      largest_N = std::max(largest_N, pen.output.force_base_N.z);
      least_N = std::min(least_N, pen.output.force_base_N.z);
    }
    EXPECT_LT(largest_N - least_N, 0.004);
  }
}

// Fast, through plates thinner than a tick's way, from both sides of a sheet.
TEST(BallTip, DoesNotPassThroughPlatesAtAnySpeed) {
  for (const double speed_m_s : {1.0, 5.0, 20.0}) {
    for (const double thickness_m : {0.0001, 0.002}) {
      Pen pen(Built(WithBall(Block(2, {0.05, 0.05, thickness_m / 2}))));
      pen.MoveTo({0, 0, 0.02});
      for (double z = 0.02; z > -0.004; z -= 1e-3 * speed_m_s) pen.MoveTo({0, 0, z});
      pen.MoveTo({0, 0, -0.004});
      pen.Rest(20);
      ASSERT_EQ(pen.output.contact_count, 1) << speed_m_s << " " << thickness_m;
      EXPECT_GT(pen.output.force_base_N.z, 1.9) << speed_m_s << " " << thickness_m;
    }
  }
}

TEST(BallTip, SticksAndSlips) {
  Material rough;
  rough.static_friction = 0.5;
  rough.dynamic_friction = 0.4;
  Pen pen(Built(WithBall(Block(8, {0.05, 0.05, 0.01}), rough)));
  pen.MoveTo({0, 0, 0.015});
  pen.Slide({0, 0, 0.015}, {0, 0, 0.012}, 100);
  pen.Slide({0, 0, 0.012}, {0.0003, 0, 0.012}, 100);
  EXPECT_NEAR(pen.output.force_base_N.x, -0.0003 * 400, 0.002);
  pen.Slide({0.0003, 0, 0.012}, {0.01, 0, 0.012}, 400);
  EXPECT_NEAR(pen.output.force_base_N.x, -0.4 * 0.4, 0.002);
}

// A surface that pops through lets the ball in, and can be touched again afterwards.
TEST(BallTip, PopsThroughAndTouchesAgainAfterLeaving) {
  Material foil = Slippery();
  foil.pop_through_N = 0.5;
  Pen pen(Built(WithBall(Block(4, {0.02, 0.02, 0.01}), foil)));
  pen.MoveTo({0, 0, 0.016});
  pen.Slide({0, 0, 0.016}, {0, 0, 0.0115}, 200);
  EXPECT_TRUE(pen.state.contacts[0].popped);
  pen.Slide({0, 0, 0.0115}, {0, 0, 0}, 200);
  EXPECT_EQ(pen.output.force_base_N, Vec3{});
  pen.Slide({0, 0, 0}, {0, 0, 0.016}, 200);
  EXPECT_FALSE(pen.state.contacts[0].active);
  pen.Slide({0, 0, 0.016}, {0, 0, 0.0125}, 200);
  EXPECT_NEAR(pen.output.force_base_N.z, 0.2, 0.002);
}

// A tip that appears inside gets a gentle force; a far one costs a check of the motion bound; nothing is allocated.
TEST(BallTip, FadesInInsideAndReturnsFromAfarWithoutAllocation) {
  Pen pen(Built(WithBall(Sphere(16, 0.02))));
  pen.config.ramp_s = 0.1;
  const loop::AllocProbe probe;
  pen.MoveTo({0, 0, 0.021});
  EXPECT_EQ(pen.output.contact_count, 1);
  EXPECT_LT(Norm(pen.output.force_base_N), 0.05);
  pen.Slide({0, 0, 0.021}, {0, 0, 0.1}, 100);
  EXPECT_EQ(pen.output.contact_count, 0);
  const double room_m = Norm(pen.state.far_origin_base_m) - 0.02 - kBall_m;
  EXPECT_GT(pen.state.far_distance_m, 0.9 * room_m);
  EXPECT_LT(pen.state.far_distance_m, room_m + 0.0005);  // facets lie within the ball
  pen.Slide({0, 0, 0.1}, {0, 0, 0.0221}, 200);
  EXPECT_EQ(pen.output.contact_count, 1);
  EXPECT_EQ(probe.count(), 0U);
}

// On a sculpted surface the ball stays outside of a bump pulled up under it.
TEST(BallTip, FollowsASurfaceSculptedUnderIt) {
  using namespace sculpt;
  SceneInput input = WithBall(Sphere(40, 0.03));
  Scene scene = Built(input);
  auto live = std::make_shared<LiveParts>();
  auto sculpt_session =
      std::make_unique<SculptSession>(EditorOf(Sphere(40, 0.03)), SculptParameters{.grab_force_N = 2}, Brush{});
  SculptEditor& editor = sculpt_session->editor();
  sculpt_session->SetReader(true);
  live->AddSculptSession(0, std::move(sculpt_session));
  scene.SetLive(std::move(live));
  Pen pen(std::move(scene));
  pen.MoveTo({0, 0, 0.036});
  pen.Slide({0, 0, 0.036}, {0, 0, 0.0325}, 100);
  EXPECT_NEAR(pen.output.force_base_N.z, 0.2, 0.02);
  double largest_step_N = 0;
  ASSERT_TRUE(editor.Begin(On(editor, {0, 0, 1}), Brush{}).ok());
  for (int k = 1; k <= 40; ++k) {
    editor.MoveTo(5e-5 * k);
    editor.Publish();
    const double before_N = pen.output.force_base_N.z;
    pen.Rest(1);
    largest_step_N = std::max(largest_step_N, std::abs(pen.output.force_base_N.z - before_N));
  }
  editor.End();
  pen.Rest(60);
  EXPECT_NEAR(pen.output.force_base_N.z, 0.2 + 0.002 * 400, 0.05);
  EXPECT_LT(largest_step_N, 0.1);
}

// The force on a coarse ball points along the radius; edges of a block are not rounded.
TEST(SmoothTag, ForceOnFacetsFollowsTheSmoothSurface) {
  Material smooth = Slippery();
  smooth.smooth = true;
  Pen shaded(Built(SceneOf(Sphere(4, 0.02), smooth))), facetted(Built(SceneOf(Sphere(4, 0.02), Slippery())));
  Random random(29);
  double shaded_error = 0, facet_error = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Vec3 n = Normalized(random.InBox(1));
    for (Pen* pen : {&shaded, &facetted}) {
      pen->MoveTo(0.03 * n);
      pen->Rest(2);
      pen->Slide(0.03 * n, 0.0178 * n, 60);
      pen->Rest(3);
      if (pen->output.contact_count == 0) continue;
      const double error = Norm(Cross(Normalized(pen->output.force_base_N), n));
      double& worst = pen == &shaded ? shaded_error : facet_error;
      worst = std::max(worst, error);
      pen->MoveTo(0.03 * n);
    }
  }
  EXPECT_GT(facet_error, 0.1);
  EXPECT_LT(shaded_error, 0.25 * facet_error);
  Pen block(Built(SceneOf(Block(1, {0.02, 0.02, 0.01}), smooth))),
      plain(Built(SceneOf(Block(1, {0.02, 0.02, 0.01}), Slippery())));
  for (double x = -0.019; x < 0.019; x += 5e-4) {
    block.MoveTo({x, 0.3 * x, 0.0095});
    plain.MoveTo({x, 0.3 * x, 0.0095});
    ASSERT_EQ(block.output.force_base_N, plain.output.force_base_N);
  }
}

}  // namespace test_haptics_ball
}  // namespace omni::haptics
