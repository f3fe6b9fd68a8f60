// Pages, generations, and input that an editor rejects.
#include <gtest/gtest.h>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "service/haptics/sculpt/sculpt_query.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_mesh {

std::uint64_t HashOf(const SculptTable& table) {
  std::uint64_t hash = 1;
  const auto mix = [&hash](double value) { hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3ULL; };
  for (const Page* page : table.pages) {
    for (std::uint32_t slot = 0; slot < kPageVertices; ++slot) {
      for (const double x :
           {page->content.vertex[slot].x, page->content.vertex[slot].y, page->content.vertex[slot].z}) {
        mix(x);
      }
    }
    for (const Triangle& t : page->content.triangle) mix(t.vertex[0] + 3.0 * t.vertex[1] + 7.0 * t.vertex[2]);
    for (const float x : page->tree.top.lower[0]) mix(double{x});
  }
  return hash;
}

Brush BrushOf(double radius_m, Falloff falloff = Falloff::kSmooth) {
  Brush brush;
  brush.radius_m = radius_m;
  brush.falloff = falloff;
  return brush;
}

TEST(SculptMeshTest, SnapshotMatchesTheInputMesh) {
  const Mesh mesh = Connected(BumpyBall(30, 0.03));
  const auto editor = SculptEditor::Make(mesh, {});
  ASSERT_TRUE(editor.ok());
  const ManifoldReport report = CheckManifold((*editor)->mesh());
  EXPECT_TRUE(report.ok()) << report.problem;
  EXPECT_EQ(report.triangles, mesh.triangles.size());
  EXPECT_EQ(report.vertices, mesh.vertices.size());
  const Mesh again = (*editor)->Snapshot();
  ASSERT_EQ(again.triangles.size(), mesh.triangles.size());
  double volume = 0, volume_again = 0;
  for (const auto& t : mesh.triangles) {
    volume += Dot(mesh.vertices[t[0]], Cross(mesh.vertices[t[1]], mesh.vertices[t[2]]));
  }
  for (const auto& t : again.triangles) {
    volume_again += Dot(again.vertices[t[0]], Cross(again.vertices[t[1]], again.vertices[t[2]]));
  }
  EXPECT_NEAR(volume_again, volume, 1e-12 * volume);
  for (std::uint32_t t = 0; t < again.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& back = again.neighbours[again.neighbours[t][k]];
      EXPECT_TRUE(back[0] == t || back[1] == t || back[2] == t);
    }
  }
}

TEST(SculptMeshTest, QueriesAgreeWithBruteForce) {
  const auto editor = EditorOf(BumpyBall(24, 0.03, 0.2));
  Random random(3);
  for (int k = 0; k < 20; ++k) (void)editor->Stroke(On(*editor, random.InBox(0.05)), BrushOf(0.01), 0.004);
  editor->Publish();
  const SculptSurface surface(*editor->publisher().newest());
  for (int k = 0; k < 300; ++k) {
    const Vec3 p = random.InBox(0.05), q = random.InBox(0.05);
    double least = 1e9, first = 2;
    for (std::uint32_t page = 0; page < surface.page_count(); ++page) {
      for (std::uint32_t slot = 0; slot < kPageTriangles; ++slot) {
        if (!surface.IsLive(IndexOf(page, slot))) continue;
        const Corners c = surface.TriangleCorners(IndexOf(page, slot));
        least = std::min(least, ClosestOnTriangle(c, p).distance_squared);
        const TriangleHit hit = IntersectTriangle(c, p, q);
        if (hit.hit && hit.front) first = std::min(first, hit.t);
      }
    }
    EXPECT_EQ(NearestInTree(surface, 0, p).closest.distance_squared, least);
    const CrossingResult crossing = CrossingInTree(surface, 0, p, q, false);
    EXPECT_EQ(crossing.t, first);
    if (crossing.triangle == kNoIndex) continue;
    const std::uint32_t component = surface.GetTriangle(crossing.triangle).component;
    EXPECT_EQ(CrossingInTree(surface, 0, p, q, false, {&component, 1}).triangle, kNoIndex);
  }
}

// What the tick holds does not change under it, and an edit copies only the pages it touches.
TEST(SculptMeshTest, OldGenerationIsUnchangedByEdits) {
  const auto editor = EditorOf(BumpyBall(60, 0.03));
  SculptPublisher& publisher = editor->publisher();
  publisher.SetReader(true);
  const SculptTable* held = publisher.Acquire();
  const std::uint64_t hash = HashOf(*held);
  const std::vector<const Page*> pages = held->pages;
  ASSERT_GT(pages.size(), 150U);
  Random random(4);
  std::size_t published = 0, refused = 0;
  for (int k = 0; k < 40; ++k) {
    ASSERT_TRUE(editor->Stroke(On(*editor, random.InBox(0.05)), BrushOf(0.004), 0.001).ok());
    const PublishReport report = editor->Publish();
    (report.published ? published : refused) += 1;
    if (published == 1 && report.published) {
      const std::vector<const Page*>& now = publisher.newest()->pages;
      std::size_t kept = 0;
      for (std::size_t i = 0; i < pages.size(); ++i) kept += now[i] == pages[i];
      EXPECT_GE(kept + report.pages, pages.size());
      EXPECT_LT(report.pages, 30U);
    }
  }
  // The reader stands still: the editor works on, but no more than kMaxTables generations exist.
  EXPECT_EQ(published, kMaxTables - 1);
  EXPECT_GT(refused, 0U);
  EXPECT_EQ(HashOf(*held), hash);
  EXPECT_EQ(held->pages, pages);
  publisher.Acquire();
  EXPECT_TRUE(editor->Publish().published);
  const SculptTable* newest = publisher.Acquire();
  EXPECT_TRUE(CheckManifold(SculptSurface(*newest)).ok());
  EXPECT_FALSE(editor->Publish().published);  // nothing new
  publisher.SetReader(false);
}

// Pages that go out and come back do not add up: memory follows the mesh, not the number of edits.
TEST(SculptMeshTest, PagesAreReused) {
  const auto editor = EditorOf(BumpyBall(30, 0.03));
  Random random(5);
  std::size_t early = 0;
  for (int k = 0; k < 400; ++k) {
    ASSERT_TRUE(editor->Stroke(On(*editor, random.InBox(0.05)), BrushOf(0.005), 0.0005).ok());
    editor->Publish();
    ASSERT_TRUE(editor->Undo());
    editor->Publish();
    if (k == 20) early = editor->mesh().page_bytes();
  }
  EXPECT_LE(editor->mesh().page_bytes(), 2 * early);
}

TEST(SculptMeshTest, RejectsOpenEmptyAndInvalidInput) {
  InputObject open = Block(2, {0.01, 0.01, 0.01});
  open.triangles.pop_back();
  open.triangle_material.pop_back();
  EXPECT_NE(SculptEditor::Make(Connected(open), {}).error().find("no second triangle"), std::string::npos);
  EXPECT_FALSE(SculptEditor::Make(Mesh{}, {}).ok());
  SculptOptions options;
  options.grid_step_m = std::nan("");
  EXPECT_FALSE(SculptEditor::Make(Connected(Tetrahedron(0.01)), options).ok());
  options = {.detail_m = -1};
  EXPECT_FALSE(SculptEditor::Make(Connected(Tetrahedron(0.01)), options).ok());
}

TEST(SculptMeshTest, RejectedStrokesChangeNothing) {
  const auto editor = EditorOf(Block(1, {0.01, 0.01, 0.01}));
  const std::uint64_t before = editor->mesh().Hash();
  const SurfacePoint at = On(*editor, {0, 0, 1});
  for (const double radius_m : {0.0, -1.0, 1e30, std::nan(""), SculptEditor::kLeastRadius_m / 2}) {
    EXPECT_FALSE(editor->Stroke(at, BrushOf(radius_m), 0.001).ok()) << radius_m;
  }
  Brush flat = BrushOf(0.005);
  flat.symmetry.enabled = true;
  flat.symmetry.normal = {};
  EXPECT_FALSE(editor->Stroke(at, flat, 0.001).ok());
  EXPECT_FALSE(editor->Stroke({}, BrushOf(0.005), 0.001).ok());
  EXPECT_FALSE(editor->Stroke({at.triangle, {std::nan(""), 0, 0}}, BrushOf(0.005), 0.001).ok());
  EXPECT_EQ(editor->mesh().Hash(), before);
  EXPECT_EQ(editor->undo_steps(), 0U);
  EXPECT_FALSE(editor->Undo());
  EXPECT_FALSE(editor->Redo());
  // Offsets that are no numbers.
  ASSERT_TRUE(editor->Begin(at, BrushOf(0.005)).ok());
  EXPECT_FALSE(editor->Undo());
  editor->MoveTo(std::nan(""));
  editor->MoveTo(std::numeric_limits<double>::infinity());
  editor->End();
  EXPECT_TRUE(CheckManifold(editor->mesh()).ok());
  EXPECT_FALSE(editor->Undo()) << "nothing was moved";
  EXPECT_EQ(editor->mesh().Hash(), before);
}

TEST(SculptMeshTest, RadiusLargerThanTheBodyMovesAllOfIt) {
  for (const Falloff falloff : {Falloff::kConstant, Falloff::kLinear, Falloff::kSmooth}) {
    const auto editor = EditorOf(Tetrahedron(0.01));
    const SurfacePoint at = On(*editor, {0, 0, 1});
    ASSERT_TRUE(editor->Stroke(at, BrushOf(1, falloff), 0.005).ok());
    EXPECT_TRUE(CheckManifold(editor->mesh()).ok());
    EXPECT_GT(editor->report().vertices, 3U);
  }
}

TEST(SculptMeshTest, PullingThroughItselfKeepsTheManifold) {
  const auto editor = EditorOf(Sphere(20, 0.02));
  for (const Falloff falloff : {Falloff::kConstant, Falloff::kLinear, Falloff::kSmooth}) {
    for (const double offset_m : {-0.06, 0.05}) {
      ASSERT_TRUE(editor->Stroke(On(*editor, {0, 0, 1}), BrushOf(0.008, falloff), offset_m).ok());
      const ManifoldReport report = CheckManifold(editor->mesh());
      ASSERT_TRUE(report.ok()) << report.problem;
    }
  }
}

// A coarse block is refined before it is shaped, and what the brush does not reach stays flat.
TEST(SculptMeshTest, ExtrudesACoarseFace) {
  const Vec3 half = PagedMesh::AsStored({0.02, 0.02, 0.01});
  const auto editor = EditorOf(Block(1, half));
  ASSERT_TRUE(editor->Stroke(On(*editor, {0.002, 0.001, 1}), BrushOf(0.008, Falloff::kConstant), 0.004).ok());
  EXPECT_GT(editor->report().vertices, 50U);
  double highest = 0;
  const Mesh mesh = editor->Snapshot();
  for (const Vec3& v : mesh.vertices) {
    highest = std::max(highest, v.z);
    if (!(v.z > 0 && std::abs(v.x) < half.x && std::abs(v.y) < half.y)) continue;
    const double away = std::hypot(v.x - 0.002, v.y - 0.001);
    if (away > 0.010) {
      EXPECT_NEAR(v.z, half.z, 1e-12);
    }
    if (away < 0.005) {
      EXPECT_NEAR(v.z, half.z + 0.004, 1e-5);
    }
  }
  EXPECT_NEAR(highest, half.z + 0.004, 5e-5);
}

TEST(SculptMeshTest, SymmetryMovesBothSidesAlike) {
  const auto editor = EditorOf(Sphere(20, 0.02));
  Brush brush = BrushOf(0.006);
  brush.symmetry.enabled = true;
  const Vec3 place{0.01, 0.003, 0.01}, twin{-0.01, 0.003, 0.01};
  ASSERT_TRUE(editor->Stroke(On(*editor, place), brush, 0.003).ok());
  editor->Publish();
  const double out = Norm(On(*editor, 5 * place).position), out_twin = Norm(On(*editor, 5 * twin).position);
  EXPECT_GT(out, 0.0225);
  EXPECT_NEAR(out, out_twin, 1e-4);
}

TEST(SculptMeshTest, OffsetsSnapToTheGrid) {
  SculptOptions options;
  options.grid_step_m = 0.002;
  const auto editor = EditorOf(Block(8, {0.02, 0.02, 0.01}), options);
  ASSERT_TRUE(editor->Stroke(On(*editor, {0, 0, 1}), BrushOf(0.008, Falloff::kConstant), 0.0033).ok());
  EXPECT_NEAR(editor->offset_m(), 0.004, 1e-15);
}

}  // namespace test_sculpt_mesh
}  // namespace omni::haptics::sculpt
