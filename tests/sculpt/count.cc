// How many triangles strokes leave behind: as many as what they formed needs.
#include <gtest/gtest.h>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_count {

// Strokes of small brushes all over a ball.
std::uint32_t GrowthAfter(int strokes, double offset_m) {
  const auto editor = EditorOf(BumpyBall(40, 0.03));
  const std::uint32_t before = editor->mesh().triangle_count();
  Random random(31);
  for (int k = 0; k < strokes; ++k) {
    Brush brush;
    brush.radius_m = random.Uniform(0.0005, 0.002);
    EXPECT_TRUE(editor->Stroke(On(*editor, random.InBox(0.05)), brush, offset_m).ok());
    editor->Publish();
  }
  const ManifoldReport report = CheckManifold(editor->mesh());
  EXPECT_TRUE(report.ok()) << report.problem;
  return editor->mesh().triangle_count() - before;
}

// The area of a brush holds pi r^2 / (sqrt(3) / 4 (r / 6)^2) = 261 triangles of its target.
TEST(SculptCountTest, GrowsWithTheAreaThatIsFormed) { EXPECT_LT(GrowthAfter(100, 0.0004), 100 * 261 * 1.2); }

TEST(SculptCountTest, StrokesThatFormNothingLeaveNothing) { EXPECT_LT(GrowthAfter(100, 2e-6), 100 * 26); }

// A flat block whose rim is stretched: nothing beyond the brush and its last edges moves or is refined for ever.
TEST(SculptCountTest, OnlyWhatIsUnderTheBrushMoves) {
  const Vec3 half = PagedMesh::AsStored({0.02, 0.02, 0.01});
  const auto editor = EditorOf(Block(20, half));
  const double radius_m = 0.004;
  Brush brush;
  brush.radius_m = radius_m;
  ASSERT_TRUE(editor->Begin(On(*editor, {0.0003, 0.0001, 1}), brush).ok());
  for (int k = 1; k <= 200; ++k) editor->MoveTo(5e-5 * k);
  editor->End();
  const Mesh mesh = editor->Snapshot();
  for (const Vec3& v : mesh.vertices) {
    const double away_m = std::hypot(v.x - 0.0003, v.y - 0.0001);
    if (v.z > half.z - 1e-9 && away_m > 1.02 * radius_m) {
      EXPECT_NEAR(v.z, half.z, 1e-9) << away_m;
    }
  }
}

}  // namespace test_sculpt_count
}  // namespace omni::haptics::sculpt
