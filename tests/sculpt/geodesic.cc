// Distances along the surface against the exact ones of a plane and of a sphere.
#include <gtest/gtest.h>

#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_geodesic {

TEST(SculptGeodesicTest, IsExactOnAFlatFace) {
  const Vec3 half{0.03, 0.03, 0.005};
  const auto editor = EditorOf(Block(24, half));
  Random random(7);
  for (int k = 0; k < 50; ++k) {
    const Vec3 at{random.Uniform(-0.012, 0.012), random.Uniform(-0.012, 0.012), 1};
    const SurfacePoint from = On(*editor, at);
    const auto ball = GeodesicBall(editor->mesh(), from, 0.015, 100'000);
    ASSERT_GT(ball.size(), 100U);
    for (const GeodesicVertex& v : ball) {
      const double exact_m = Norm(editor->mesh().VertexPosition(v.vertex) - from.position);
      EXPECT_NEAR(v.distance_m, exact_m, 1e-9 + 1e-3 * exact_m);
    }
  }
}

TEST(SculptGeodesicTest, IsWithinOnePercentOnASphere) {
  const double radius_m = 0.03;
  const auto editor = EditorOf(Sphere(40, radius_m));
  Random random(8);
  for (int k = 0; k < 20; ++k) {
    const SurfacePoint from = On(*editor, random.InBox(1));
    const auto ball = GeodesicBall(editor->mesh(), from, 0.03, 100'000);
    double worst = 0;
    for (const GeodesicVertex& v : ball) {
      const Vec3 a = Normalized(editor->mesh().VertexPosition(v.vertex)), b = Normalized(from.position);
      const double exact_m = radius_m * std::atan2(Norm(Cross(a, b)), Dot(a, b));
      if (exact_m > 0.003) worst = std::max(worst, std::abs(v.distance_m / exact_m - 1));
    }
    EXPECT_LT(worst, 0.01);
  }
}

// Around the rim of a block: the way over the edge, not the straight line.
TEST(SculptGeodesicTest, GoesAroundEdges) {
  const auto editor = EditorOf(Block(20, {0.01, 0.01, 0.01}));
  const SurfacePoint from = On(*editor, {0.008, 0, 0.02});
  bool found = false;
  for (const GeodesicVertex& v : GeodesicBall(editor->mesh(), from, 0.012, 100'000)) {
    const Vec3 p = editor->mesh().VertexPosition(v.vertex);
    if (!(p.x > 0.0099 && std::abs(p.y) < 1e-9 && p.z < 0.009)) continue;
    found = true;
    const double exact_m = (0.01 - from.position.x) + (0.01 - p.z);
    EXPECT_NEAR(v.distance_m, exact_m, 0.01 * exact_m);
  }
  EXPECT_TRUE(found);
}

TEST(SculptGeodesicTest, StopsAtItsLimits) {
  const auto editor = EditorOf(Sphere(20, 0.03));
  const SurfacePoint from = On(*editor, {0, 0, 1});
  EXPECT_TRUE(GeodesicBall(editor->mesh(), from, 0, 10).empty());
  EXPECT_TRUE(GeodesicBall(editor->mesh(), from, std::nan(""), 10).empty());
  EXPECT_EQ(GeodesicBall(editor->mesh(), from, 1, 10).size(), 11U);
  EXPECT_EQ(GeodesicBall(editor->mesh(), from, 1, 100'000).size(), editor->mesh().vertex_count());
}

}  // namespace test_sculpt_geodesic
}  // namespace omni::haptics::sculpt
