// The ball where its place is known by formula: planes, grooves, corners, curved surfaces, plates at speed.
#include <gtest/gtest.h>

#include "service/haptics/contact/proxy.h"
#include "service/haptics/contact/shading.h"
#include "service/haptics/scene/scene.h"
#include "tests/geometry/ball_scenario.h"
#include "tests/support/alloc_probe.h"

namespace omni::haptics {
namespace test_geometry_ball {

constexpr double kDegree = std::numbers::pi / 180;

// Within this many radii of its formula.
constexpr double kExact = 3 * kBallMargin;

TEST(Ball, RestsOnAPlaneWhateverItsTessellation) {
  for (const int n : {1, 7, 40}) {
    for (const double radius_m : {1e-5, 5e-4, 2e-3, 1e-2}) {
      BallScenario ball(Built(SceneOf(Block(n, {0.03, 0.03, 0.01}))), radius_m, {0, 0, 0.03});
      Random random(1001);
      Vec3 tip{0, 0, 0.03};
      for (int k = 0; k < 1500; ++k) {
        tip = tip + random.InBox(5e-4) + Vec3{-0.02 * tip.x, -0.02 * tip.y, -0.05 * (tip.z - 0.0105)};
        ball.MoveTo(tip);
        const double height_m = std::max(tip.z, 0.01 + radius_m);
        ASSERT_LT(Norm(ball.state.centre_m - Vec3{tip.x, tip.y, height_m}), kExact * radius_m)
            << n << " " << radius_m << " " << k;
        ASSERT_TRUE(ball.contact.settled);
        if (tip.z > 0.01 + radius_m * (1 + 1e-3)) {
          ASSERT_EQ(ball.contact.touch_count, 0);
          ASSERT_EQ(ball.state.centre_m, tip);
        }
        if (tip.z < 0.01 + radius_m * (1 - 1e-3)) {
          ASSERT_EQ(ball.contact.touch_count, 1);
          ASSERT_NEAR(ball.contact.touches[0].share, 1, 1e-3);
          ASSERT_GT(ball.contact.touches[0].normal.z, 1 - 1e-6);
        }
      }
    }
  }
}

std::vector<std::array<double, 2>> GrooveProfile(double opening_deg, double depth_m) {
  const double half_m = depth_m * std::tan(0.5 * opening_deg * kDegree);
  return {{-0.03 - half_m, 0}, {-half_m, 0}, {0, -depth_m}, {half_m, 0}, {0.03 + half_m, 0}};
}

// Pressed into a groove, the ball lies on both walls at once: its centre r / sin(opening / 2) over the bottom, and the
// walls share the push as statics says. At rest nothing moves at all.
TEST(Ball, RestsOnBothWallsOfAGroove) {
  Random random(1002);
  for (const double opening_deg : {10.0, 30.0, 60.0, 90.0, 120.0, 150.0, 170.0}) {
    for (const int cut : {1, 6}) {
      const double radius_m = random.Uniform(3e-4, 1e-3), depth_m = 0.012;
      const double half = 0.5 * opening_deg * kDegree;
      if (!(radius_m / std::tan(half) < depth_m * 0.8 / std::cos(half))) continue;
      BallScenario ball(Built(SceneOf(ProfileSheet(GrooveProfile(opening_deg, depth_m), 0.02, cut, cut))), radius_m,
                        {0, 0, 0.02});
      for (int place = 0; place < 20; ++place) {
        const double y = random.Uniform(-0.01, 0.01), side = random.Uniform(-0.9, 0.9);
        // Between the normals of the walls, seen from where the centre will be: both walls push.
        const Vec3 rest{0, y, -depth_m + radius_m / std::sin(half)};
        const double turn = side * (90 * kDegree - half), push_m = random.Uniform(2e-4, 1e-3);
        const Vec3 tip = rest - push_m * Vec3{std::sin(turn), 0, std::cos(turn)};
        ball.Slide({0, y, 0.01}, {0, y, rest.z + 1e-4}, 60);
        ball.Slide({0, y, rest.z + 1e-4}, tip, 20);
        ball.Rest(30);
        ASSERT_LT(Norm(ball.state.centre_m - rest), 3 * kExact * radius_m / std::sin(half)) << opening_deg;
        ASSERT_EQ(ball.contact.touch_count, 2) << opening_deg << " " << side;
        ASSERT_LT(Norm(ball.SumOfShares() - Normalized(ball.Push())), 1e-6);
        const Vec3 still = ball.state.centre_m;
        double ripple_m = 0;
        for (int k = 0; k < 50; ++k) {
          ball.Rest(1);
          ripple_m = std::max(ripple_m, Norm(ball.state.centre_m - still));
        }
        EXPECT_LT(ripple_m, 1e-3 * push_m) << opening_deg;
        ball.Slide(tip, {0, y, 0.01}, 40);
        ASSERT_EQ(ball.state.centre_m, ball.state.device_point_m);
      }
    }
  }
}

// Three walls that meet in a corner, of any attitude, within the same tick.
TEST(Ball, RestsOnThreeWallsOfACorner) {
  Random random(1003);
  for (int round = 0; round < 60; ++round) {
    const Vec3 a = Normalized(random.InBox(1)), b = Normalized(Cross(a, random.InBox(1))), c = Cross(a, b);
    const double radius_m = random.Uniform(3e-4, 3e-3), size_m = 0.03;
    InputObject corner;
    corner.name = "corner";
    corner.double_sided = true;
    const Vec3 axes[] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      const Vec3 u = size_m * axes[(k + 1) % 3], v = size_m * axes[(k + 2) % 3];
      const auto base = static_cast<std::uint32_t>(corner.vertices_base_m.size());
      for (const Vec3& p : {Vec3{}, u, u + v, v}) corner.vertices_base_m.push_back(p);
      AddTriangle(corner, base, base + 1, base + 2);
      AddTriangle(corner, base, base + 2, base + 3);
    }
    const Vec3 out = a + b + c;
    BallScenario ball(Built(SceneOf(corner)), radius_m, 0.01 * out);
    const Vec3 push = random.Uniform(1e-4, 1e-3) * a + random.Uniform(1e-4, 1e-3) * b + random.Uniform(1e-4, 1e-3) * c;
    const Vec3 rest = radius_m * out;
    ball.MoveTo(rest - push);
    ASSERT_TRUE(ball.contact.settled);
    ASSERT_LT(Norm(ball.state.centre_m - rest), 2 * kExact * radius_m);
    ASSERT_EQ(ball.contact.touch_count, 3);
    ASSERT_TRUE(ball.contact.settled);
    ASSERT_LT(Norm(ball.SumOfShares() - Normalized(ball.Push())), 1e-6);
    for (int k = 0; k < 3; ++k) {  // the walls' shares are the push's components, up to the give
      const BallTouch& touch = ball.contact.touches[static_cast<std::size_t>(k)];
      ASSERT_NEAR(touch.share, Dot(touch.normal, Normalized(push)), 0.01 + 6 * kExact * radius_m / Norm(push));
    }
  }
}

// On a round body the centre is r over the surface where the device point is: facets sag by no more than what is
// allowed for.
TEST(Ball, FollowsOffsetOfCurvedSurfaces) {
  Random random(1004);
  constexpr double kBody_m = 0.02;
  const Scene scene = Built(SceneOf(Sphere(60, kBody_m)));
  const double sagitta_m = 0.5 * kBody_m * std::pow(0.5 * std::numbers::pi / 60, 2);
  for (const double radius_m : {2e-4, 1e-3, 6e-3}) {
    BallScenario ball(scene, radius_m, {0, 0, 0.03});
    Vec3 direction{0, 0, 1};
    for (int k = 0; k < 2000; ++k) {
      direction = Normalized(direction + random.InBox(0.01));
      const double press_m = 5e-4 + 5e-4 * std::sin(0.01 * k);
      ball.MoveTo((kBody_m + radius_m - press_m) * direction);
      const double distance_m = Norm(ball.state.centre_m);
      ASSERT_GT(distance_m, kBody_m + radius_m - 2 * sagitta_m) << radius_m << " " << k;
      ASSERT_LT(distance_m, kBody_m + radius_m + kExact * radius_m) << radius_m << " " << k;
      if (press_m > 3e-4) {
        const Vec3 push = Normalized(ball.Push());
        ASSERT_GT(Dot(push, direction), std::cos(3.0 * kDegree)) << radius_m << " " << k;  // facets meet at 2 degrees
      }
    }
  }
}

// Inside a hollow ball, where every facet is concave, and in the ring of a torus.
TEST(Ball, FollowsOffsetOfHollowSurfaces) {
  Random random(1005);
  constexpr double kBody_m = 0.02;
  SceneInput input = SceneOf(Sphere(50, kBody_m));
  input.objects[0].double_sided = true;
  const Scene scene = Built(input);
  const double sagitta_m = 0.5 * kBody_m * std::pow(0.5 * std::numbers::pi / 50, 2);
  for (const double radius_m : {3e-4, 2e-3, 8e-3}) {
    BallScenario ball(scene, radius_m, {});
    Vec3 direction{0, 0, 1};
    for (int k = 0; k < 2000; ++k) {
      direction = Normalized(direction + random.InBox(0.02));
      ball.MoveTo((kBody_m - radius_m + 1e-3) * direction);
      const double distance_m = Norm(ball.state.centre_m);
      ASSERT_LT(distance_m, kBody_m - radius_m + kExact * radius_m) << radius_m << " " << k;
      ASSERT_GT(distance_m, kBody_m - radius_m - 3 * sagitta_m) << radius_m << " " << k;
    }
    ball.Rest(20);
    EXPECT_TRUE(ball.contact.settled);
    EXPECT_GT(Dot(Normalized(ball.Push()), -direction), std::cos(4 * kDegree));
  }
}

// A plate in any attitude, at any speed, with ticks missing: the ball stays on the side it came from. Balls of less
// than the plate's thickness as well as of much more.
TEST(Ball, DoesNotPassThroughPlates) {
  Random random(1006);
  for (const double thickness_m : {1e-4, 5e-4, 2e-3}) {
    for (const double speed_m_s : {1.0, 5.0, 20.0}) {
      for (const double radius_m : {2e-5, 3e-4, 4e-3}) {
        for (int round = 0; round < 8; ++round) {
          const Vec3 normal = Normalized(random.InBox(1));
          const Vec3 u = Normalized(Cross(normal, random.InBox(1))), v = Cross(normal, u);
          SceneInput input = SceneOf(CubeGrid(6, [&](const Vec3& p) {
            return (0.03 * p.x) * u + (0.03 * p.y) * v + (0.5 * thickness_m * p.z) * normal;
          }));
          input.objects[0].double_sided = round % 3 == 0;
          const double side = round % 2 == 0 ? 1 : -1, step_m = speed_m_s * (round < 4 ? 1e-3 : 20e-3);
          double height_m = radius_m + random.Uniform(0.001, 0.001 + step_m);
          const Vec3 aside = random.Uniform(-0.01, 0.01) * u + random.Uniform(-0.01, 0.01) * v;
          BallScenario ball(Built(input), radius_m, aside + (side * height_m) * normal);
          while (height_m > -0.008) {
            height_m = std::max(height_m - step_m, -0.009);
            ball.MoveTo(aside + (side * height_m) * normal);
            ASSERT_GT(ball.Gap(), -2.1 * kBallMargin);
          }
          ball.Rest(60);
          const double rest_m = 0.5 * thickness_m + radius_m;
          EXPECT_NEAR(side * Dot(ball.state.centre_m, normal), rest_m, kExact * radius_m) << thickness_m << speed_m_s;
          ASSERT_EQ(ball.contact.touch_count, 1) << thickness_m << " " << speed_m_s << " " << radius_m;
          EXPECT_GT(side * Dot(ball.contact.touches[0].normal, normal), 0.999);
        }
      }
    }
  }
}

// Flying past a plate's edge in one tick, the ball is caught exactly if its flank meets the edge on the way.
TEST(Ball, FlankIsCaughtByAPlateEdge) {
  Random random(1007);
  int caught = 0, passed = 0;
  for (int round = 0; round < 400; ++round) {
    const double thickness_m = std::array{1e-4, 5e-4, 2e-3}[static_cast<std::size_t>(round % 3)];
    const double radius_m = random.Uniform(2e-4, 4e-3);
    BallScenario ball(Built(SceneOf(Block(1, {0.02, 0.02, 0.5 * thickness_m}))), radius_m, {0, 0, 0.03});
    const double x = 0.02 + radius_m * random.Uniform(0.2, 1.8), y = random.Uniform(-0.015, 0.015);
    const double from_m = random.Uniform(0.005, 0.012);
    ball.Restart({x, y, from_m});
    ball.MoveTo({x, y, -from_m});
    const double overlap = (0.02 + radius_m - x) / radius_m;
    if (std::abs(overlap) < 3 * kBallMargin) continue;
    if (overlap < 0) {
      ASSERT_EQ(ball.state.centre_m, (Vec3{x, y, -from_m})) << round;
      ++passed;
    } else {  // it slides off the edge, in this tick or later, but never passes through
      ASSERT_GT(ball.Gap(), -2.1 * kBallMargin) << round;
      ball.MoveTo({0.5 * (x + 0.02) - 0.5 * radius_m, y, -from_m});
      ASSERT_GT(ball.Gap(), -2.1 * kBallMargin) << round;
      ++caught;
    }
  }
  EXPECT_GT(caught, 100);
  EXPECT_GT(passed, 100);
}

// A hole stops the ball that is larger than it and lets the smaller one through: a point tip cannot do this.
TEST(Ball, HoleStopsLargerBallsOnly) {
  InputObject plate;
  plate.name = "plate with a hole";
  plate.double_sided = true;
  const auto at = [](std::uint32_t i, std::uint32_t j) { return i * 4 + j; };
  constexpr double kPlaces_m[] = {-0.02, -0.001, 0.001, 0.02};
  for (const double x : kPlaces_m) {
    for (const double y : kPlaces_m) plate.vertices_base_m.push_back({x, y, 0});
  }
  for (std::uint32_t i = 0; i < 3; ++i) {
    for (std::uint32_t j = 0; j < 3; ++j) {
      if (i == 1 && j == 1) continue;
      AddTriangle(plate, at(i, j), at(i + 1, j), at(i + 1, j + 1));
      AddTriangle(plate, at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  const Scene scene = Built(SceneOf(plate));
  for (const double radius_m : {5e-4, 9e-4, 1.1e-3, 3e-3}) {
    BallScenario ball(scene, radius_m, {1e-5, 2e-5, 0.01});
    ball.Slide({1e-5, 2e-5, 0.01}, {1e-5, 2e-5, -0.004}, 40);
    ball.Rest(40);
    if (radius_m < 0.001) {
      EXPECT_EQ(ball.contact.touch_count, 0) << radius_m;
    } else {
      const double height_m = std::sqrt(radius_m * radius_m - 1e-6);  // on the rim, 1 mm beside
      EXPECT_NEAR(ball.state.centre_m.z, height_m, 0.02 * radius_m) << radius_m;
      EXPECT_LT(std::hypot(ball.state.centre_m.x, ball.state.centre_m.y), 2e-5) << radius_m;
    }
  }
}

// As the radius goes to zero the centre goes to the point proxy; on a round body it may rest on another facet near by,
// three of them apart at most.
TEST(Ball, SmallBallConvergesToThePointProxy) {
  Random random(1008);
  constexpr double kFacets = 3 * 90 * kDegree / 40;
  const std::pair<Scene, double> cases[] = {{Built(SceneOf(Block(5, {0.02, 0.02, 0.02}))), 0},
                                            {Built(SceneOf(Sphere(40, 0.02))), kFacets}};
  for (const auto& [scene, angle] : cases) {
    for (const double radius_m : {1e-4, 1e-5, 1e-6}) {
      BallScenario ball(scene, radius_m, {0.001, 0.002, 0.022});
      const Surface& surface = ball.surface();
      Vec3 tip{0.001, 0.002, 0.022};
      std::uint32_t triangle = kNoIndex;
      int compared = 0;
      for (int k = 0; k < 3000; ++k) {
        tip = tip + random.InBox(2e-4) + Vec3{-0.01 * tip.x, -0.01 * tip.y, -0.05 * (tip.z - 0.0195)};
        const bool was_free = ball.contact.touch_count == 0;
        const Vec3 last = ball.state.device_point_m;
        ball.MoveTo(tip);
        if (was_free || triangle == kNoIndex) {
          triangle = CrossingInTree(surface, ball.object().root, last, tip, false).triangle;
        }
        if (triangle == kNoIndex || ball.contact.touch_count == 0) continue;
        const ProxyPoint proxy = DescendOnSurface(surface, triangle, tip);
        triangle = proxy.triangle;
        if (ClassifyProxy(surface, proxy, tip, 1) == ProxyVerdict::kOutside) {
          triangle = kNoIndex;
          continue;
        }
        const double depth_m = std::sqrt(proxy.closest.distance_squared);
        ASSERT_LT(Norm(ball.state.centre_m - proxy.closest.point), 1.1 * radius_m + angle * depth_m) << k;
        ++compared;
      }
      EXPECT_GT(compared, 500);
    }
  }
}

// Wherever the device point first appears, inside of bodies and within the ball's radius of them included, the ball
// starts outside and comes to rest near it.
TEST(Ball, StartsOutside) {
  Random random(1009);
  const Scene scene =
      Built(SceneOf(Periodic(60, 24, [](double u, double v) { return TorusPoint(0.02, 0.006, u, v); })));
  for (const double radius_m : {1e-4, 2e-3, 1e-2}) {
    for (int k = 0; k < 300; ++k) {
      BallScenario ball(scene, radius_m, random.InBox(0.03));
      ball.Rest(10);
      ASSERT_GT(ball.Gap(), -2.1 * kBallMargin) << radius_m << " " << k;
      ASSERT_LT(WindingNumber(scene, ball.surface(), ball.state.centre_m), 0.5) << radius_m << " " << k;
      ASSERT_LT(Norm(ball.Push()), 0.04) << radius_m << " " << k;
    }
  }
}

// A face that rises by less than the radius a tick pushes the ball along with it.
TEST(Ball, IsPushedByARisingFace) {
  SceneInput input = SceneOf(Block(4, {0.02, 0.02, 0.01}));
  input.materials[0].extrude.enabled = true;
  const Scene scene = Built(input);
  std::size_t top = 0;
  while (top < scene.regions().size() && !(scene.regions()[top].normal.z > 0.9)) ++top;
  ASSERT_LT(top, scene.regions().size());
  for (const double radius_m : {3e-4, 2e-3}) {
    const Vec3 tip{0.003, -0.002, 0.01 + radius_m - 1e-4};
    std::array<RegionState, kMaxRegions> regions{};
    BallState state = StartBall(Surface(scene, regions), scene.objects()[0].root, Inside::kBySign, radius_m, tip);
    for (int k = 0; k <= 16; ++k) {
      regions[top].offset_m = 2.5e-4 * k;
      const Surface surface(scene, regions);
      const BallContact contact = FollowBall(surface, scene.objects()[0].root, radius_m, tip, state);
      ASSERT_EQ(contact.touch_count, 1) << k;
      ASSERT_NEAR(state.centre_m.z, 0.01 + 2.5e-4 * k + radius_m, kExact * radius_m) << k;
    }
  }
}

TEST(Ball, AllocatesNothing) {
  BallScenario ball(Built(SceneOf(Sphere(40, 0.02))), 2e-3, {0, 0, 0.03});
  Random random(1010);
  const loop::AllocProbe probe;
  int touches = 0;
  for (int k = 0; k < 300; ++k) {
    ball.MoveTo(random.InBox(0.02));
    touches += ball.contact.touch_count;
    if (ball.contact.touch_count == 0) continue;
    const BallTouch& touch = ball.contact.touches[0];
    const Vec3 shaded = ShadedDirection(ball.surface(), touch.triangle, touch.at, touch.normal);
    if (!(Dot(shaded, touch.normal) > 0.8)) break;
  }
  const std::uint64_t calls = probe.count();
  EXPECT_EQ(calls, 0U);
  EXPECT_GT(touches, 150);
}

// A device point that is no number changes nothing.
TEST(Ball, IgnoresNonFiniteDevicePoints) {
  BallScenario ball(Built(SceneOf(Sphere(8, 0.02))), 1e-3, {0, 0, 0.0205});
  const BallState before = ball.state;
  for (const double odd : {std::nan(""), HUGE_VAL, -1e300}) {
    EXPECT_EQ(ball.MoveTo({0, odd, 0}).touch_count, 0);
    EXPECT_EQ(ball.state.centre_m, before.centre_m);
    EXPECT_EQ(ball.state.device_point_m, before.device_point_m);
  }
}

}  // namespace test_geometry_ball
}  // namespace omni::haptics
