// Hundreds of random strokes: the mesh stays closed, oriented, 2-manifold, with positive areas; all can be undone.
#include <gtest/gtest.h>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_strokes {

Brush RandomBrush(Random& random, double radius_low_m, double radius_high_m) {
  Brush brush;
  brush.radius_m = random.Uniform(radius_low_m, radius_high_m);
  brush.falloff = static_cast<Falloff>(random.Next() % 3);
  brush.symmetry.enabled = random.Next() % 4 == 0;
  brush.symmetry.normal = random.InBox(1);
  return brush;
}

// Strokes anywhere on the body, in and out; some undone, some of those redone.
void Sculpt(SculptEditor& editor, Random& random, int strokes, double size_m, double offset_m) {
  for (int i = 0; i < strokes; ++i) {
    const SurfacePoint at = On(editor, random.InBox(1.5 * size_m));
    ASSERT_NE(at.triangle, kNoIndex);
    const Brush brush = RandomBrush(random, 0.15 * size_m, 0.3 * size_m);
    (void)editor.Stroke(at, brush, random.Uniform(-offset_m, offset_m));  // refused where too many would move
    if (random.Next() % 8 == 0 && editor.Undo() && random.Next() % 2 == 0) editor.Redo();
    editor.Publish();
    if (i % 50 == 49) {
      const ManifoldReport report = CheckManifold(editor.mesh());
      ASSERT_TRUE(report.ok()) << report.problem << " after stroke " << i;
      ASSERT_GT(report.least_shape, 1e-4) << "after stroke " << i;
    }
  }
}

struct Case {
  const char* name;
  InputObject body;
  double size_m;
  double offset_m;
  int strokes;
};

class Strokes : public ::testing::TestWithParam<int> {};

std::vector<Case> Cases() {
  return {
      {"ball", BumpyBall(10, 0.03), 0.03, 0.006, 80},
      {"block", Block(1, {0.02, 0.015, 0.01}), 0.02, 0.004, 70},
      {"tetrahedron", Tetrahedron(0.02), 0.02, 0.006, 60},
      {"torus", Periodic(24, 12, [](double u, double v) { return TorusPoint(0.02, 0.008, u, v); }), 0.02, 0.005, 70}};
}

TEST_P(Strokes, KeepManifoldAndUndoExactly) {
  const Case c = Cases()[static_cast<std::size_t>(GetParam())];
  SCOPED_TRACE(c.name);
  const auto editor = EditorOf(c.body);
  ASSERT_NE(editor, nullptr);
  const std::uint64_t before = editor->mesh().Hash();
  const std::uint32_t triangles = editor->mesh().triangle_count();
  Random random(17 + static_cast<std::uint64_t>(GetParam()));
  Sculpt(*editor, random, c.strokes, c.size_m, c.offset_m);
  const std::uint64_t after = editor->mesh().Hash();
  EXPECT_NE(after, before);
  std::size_t undone = 0;
  while (editor->Undo()) ++undone;
  EXPECT_GT(undone, static_cast<std::size_t>(c.strokes) / 2);
  EXPECT_EQ(editor->mesh().Hash(), before);
  EXPECT_EQ(editor->mesh().triangle_count(), triangles);
  while (editor->Redo()) {
  }
  EXPECT_EQ(editor->mesh().Hash(), after);
  const ManifoldReport report = CheckManifold(editor->mesh());
  EXPECT_TRUE(report.ok()) << report.problem;
}

INSTANTIATE_TEST_SUITE_P(Bodies, Strokes, ::testing::Range(0, 4));

}  // namespace test_sculpt_strokes
}  // namespace omni::haptics::sculpt
