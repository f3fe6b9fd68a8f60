// After many strokes of any brush: what was saved loads as what was felt, closed, sculptable, and with an inside and an
// outside everywhere.
#include <gtest/gtest.h>

#include <set>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "service/scene/glb_save.h"
#include "service/scene/scene_file.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/touch/ball_judge.h"
#include "tests/support/touch/inside_judge.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_reload {

struct Style {
  const char* name;
  double least_radius_m, most_radius_m;
  double in, out;   // offset, in radii
  double spread_m;  // 0: strokes anywhere; else about one place, on top of each other
  int strokes;
};

constexpr std::array kStyles{
    Style{"push", 0.005, 0.005, -1, -0.5, 0, 30},
    Style{"pull", 0.005, 0.005, 0.5, 1, 0, 30},
    Style{"small", 0.0005, 0.002, -0.8, 0.8, 0, 40},
    Style{"large", 0.008, 0.02, -0.4, 0.4, 0, 40},
    Style{"one place", 0.002, 0.006, -1, 1, 0.003, 30},
    Style{"tiny, one place", 1e-4, 5e-4, -1, 1, 0.0005, 30},
    Style{"pushed, one place", 0.003, 0.005, -1, -0.5, 0.003, 30},
};

void Sculpt(const Style& style, std::uint64_t seed, SculptEditor& editor) {
  Random random(seed);
  const Vec3 place = Normalized(random.InBox(1));
  for (int k = 0; k < style.strokes; ++k) {
    const Vec3 at = style.spread_m > 0 ? 0.03 * place + random.InBox(style.spread_m) : random.InBox(0.05);
    Brush brush;
    brush.radius_m = random.Uniform(style.least_radius_m, style.most_radius_m);
    brush.falloff = static_cast<Falloff>(random.Next() % 3);
    (void)editor.Stroke(On(editor, at), brush, brush.radius_m * random.Uniform(style.in, style.out));
    editor.Publish();
  }
}

SceneInput SceneWith(const Mesh& mesh) {
  Material clay;
  clay.sculpt.enabled = true;
  clay.static_friction = clay.dynamic_friction = clay.damping_Ns_m = 0;
  InputObject object;
  object.name = "clay";
  object.vertices_base_m = mesh.vertices;
  object.triangles = mesh.triangles;
  object.triangle_material = mesh.material;
  return SceneOf(std::move(object), clay);
}

// Corners of each triangle, from the least of them on.
std::multiset<std::array<double, 9>> Faces(const std::vector<Vec3>& vertices,
                                           const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::multiset<std::array<double, 9>> faces;
  for (const auto& t : triangles) {
    std::array<double, 9> least{};
    for (std::size_t turn = 0; turn < 3; ++turn) {
      std::array<double, 9> face{};
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& v = vertices[t[(turn + k) % 3]];
        face[3 * k] = v.x;
        face[3 * k + 1] = v.y;
        face[3 * k + 2] = v.z;
      }
      least = turn == 0 ? face : std::min(least, face);
    }
    faces.insert(least);
  }
  return faces;
}

class Reload : public ::testing::TestWithParam<std::size_t> {};

TEST_P(Reload, IsWhatWasFeltAndHasTwoSides) {
  const Style& style = kStyles[GetParam()];
  SCOPED_TRACE(style.name);
  const auto editor = EditorOf(BumpyBall(20, 0.03));
  Sculpt(style, 40 + GetParam(), *editor);
  const Mesh felt = editor->Snapshot();
  const test::TempFolder folder;
  const std::string path = folder.Path("clay.glb");
  ASSERT_TRUE(scene::SaveGlb(path, SceneWith(felt)).ok());
  scene::LoadReport report;
  auto loaded = scene::LoadSceneFile(path, {}, report);
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
  // Closed, sculptable, and the same, bit by bit.
  RepairCounts counts;
  Mesh again = RepairMesh(loaded->objects[0], counts);
  EXPECT_EQ(counts.degenerate + counts.duplicate, 0U);
  const TopologyReport topology = ConnectAndOrient(again);
  EXPECT_TRUE(topology.IsClosed());
  EXPECT_EQ(topology.snapped + topology.closed_holes, 0U);
  EXPECT_TRUE(Faces(again.vertices, again.triangles) == Faces(felt.vertices, felt.triangles));
  const auto editor_again = SculptEditor::Make(again, {});
  ASSERT_TRUE(editor_again.ok()) << editor_again.error();
  const ManifoldReport manifold = CheckManifold((*editor_again)->mesh());
  EXPECT_TRUE(manifold.ok()) << manifold.problem;
  const Mesh snapshot = (*editor_again)->Snapshot();
  EXPECT_TRUE(Faces(snapshot.vertices, snapshot.triangles) == Faces(felt.vertices, felt.triangles));
  // A pen strokes it, within and around what was formed.
  loaded->tip_radius_m = 0;
  Pen pen(Built(*loaded));
  SlidingHand hand(pen.scene(), 0, 7 + GetParam());
  InsideJudge judge(CornersOf(Surface(pen.scene(), {}), pen.scene().objects()[0]));
  for (int k = 0; k < 6000; ++k) {
    const Vec3 tip = hand.Next();
    pen.MoveTo(tip);
    judge.Judge(tip, ContactWith(0, pen.state) != nullptr);
  }
  EXPECT_GT(judge.touching, 500U);
  EXPECT_EQ(judge.missed, 0U);
  EXPECT_EQ(judge.false_contacts, 0U);
  EXPECT_EQ(judge.crossed, 0U) << "places that the body lies around more than once";
}

INSTANTIATE_TEST_SUITE_P(Styles, Reload, ::testing::Range(std::size_t{0}, kStyles.size()));

}  // namespace test_sculpt_reload
}  // namespace omni::haptics::sculpt
