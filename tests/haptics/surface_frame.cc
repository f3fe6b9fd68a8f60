// Surfaces as they are drawn, against the tick's own.
#include "service/haptics/live/surface_frame.h"

#include <gtest/gtest.h>

#include <map>

#include "service/haptics/geometry/surface.h"
#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "tests/deformable/scenario.h"
#include "tests/support/soft_step.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics {
namespace test_haptics_surface_frame {

// A rigid ball, and one that its application moves.
SceneInput TwoBalls() {
  SceneInput input = SceneOf(SoftBallMesh());
  InputObject second = SoftBallMesh();
  second.name = "second";
  for (Vec3& p : second.vertices_base_m) p.x += 0.1;
  second.kinematic = true;
  input.objects.push_back(second);
  return input;
}

// A block whose top is one extrudable face.
SceneInput BlockWithTop() {
  SceneInput input = SceneOf(Block(6, {0.02, 0.02, 0.01}));
  Material clay;
  clay.extrude.enabled = true;
  input.materials.push_back(clay);
  InputObject& block = input.objects[0];
  for (std::size_t t = 0; t < block.triangles.size(); ++t) {
    bool on_top = true;
    for (const std::uint32_t v : block.triangles[t]) on_top = on_top && block.vertices_base_m[v].z == 0.01;
    if (on_top) block.triangle_material[t] = 1;
  }
  return input;
}

double AsDouble(float x) { return double{x}; }
Vec3 PlaceOf(const DrawnVertex& v) { return {AsDouble(v[0]), AsDouble(v[1]), AsDouble(v[2])}; }

TEST(SurfaceFrame, VerticesAreNumberedInOrderOfFirstUseByTriangles) {
  const Scene scene = Built(TwoBalls());
  for (std::uint32_t o = 0; o < 2; ++o) {
    const VertexRange range = VerticesOf(scene, o);
    std::vector<DrawnTriangle> triangles;
    DrawnTriangles(scene, o, triangles);
    ASSERT_EQ(triangles.size(), scene.objects()[o].triangle_count);
    std::uint32_t next = 0;
    for (const DrawnTriangle& t : triangles) {
      for (const std::uint32_t v : t) {
        ASSERT_LE(v, next);
        next = std::max(next, v + 1);
      }
    }
    EXPECT_EQ(next, range.count);
  }
  EXPECT_EQ(VerticesOf(scene, 0).count + VerticesOf(scene, 1).count, scene.vertices().size());
}

// Soft bodies and editors are made from the drawn mesh, vertex by vertex.
TEST(SurfaceFrame, VertexOrderMatchesMeshOf) {
  const Scene scene = Built(TwoBalls());
  for (std::uint32_t o = 0; o < 2; ++o) {
    const Mesh mesh = MeshOf(scene, o);
    std::vector<DrawnTriangle> triangles;
    DrawnTriangles(scene, o, triangles);
    EXPECT_EQ(RestOf(scene, o).vertices_base_m, mesh.vertices);
    EXPECT_EQ(triangles, mesh.triangles);
  }
}

TEST(SurfaceFrame, ListsObjectsThatChange) {
  const Scene balls = Built(TwoBalls());
  EXPECT_EQ(ChangingObjects(balls), (std::vector<ChangingObject>{{.object = 1, .moved = true}}));
  const Scene block = Built(BlockWithTop());
  EXPECT_EQ(ChangingObjects(block), (std::vector<ChangingObject>{{.object = 0, .extruded = true}}));
  EXPECT_TRUE(ChangingObjects(Scene()).empty());
  EXPECT_TRUE(ChangingObjects(Built(SceneOf(SoftBallMesh()))).empty()) << "a rigid scene has nothing to redraw";
}

// Each vertex where the tick's own view of the surface has it.
TEST(SurfaceFrame, ExtrudedVerticesMatchTheHapticSurface) {
  const Scene scene = Built(BlockWithTop());
  ASSERT_EQ(scene.regions().size(), 1U);
  RestObject rest = RestOf(scene, 0);
  Random random(5);
  for (int round = 0; round < 50; ++round) {
    State state;
    state.regions[0].offset_m = random.Uniform(-0.01, 0.01);
    std::vector<DrawnVertex> drawn;
    const double largest_m = DisplacedVertices(scene, {state.soft, state.regions}, rest, drawn);
    EXPECT_NEAR(largest_m, std::abs(state.regions[0].offset_m), 1e-12);
    const Surface surface(scene, state.regions);
    ASSERT_EQ(drawn.size(), rest.range.count);
    for (std::uint32_t v = 0; v < rest.range.count; ++v) {
      ASSERT_LT(Norm(PlaceOf(drawn[v]) - surface.VertexPosition(rest.range.first + v)), 1e-8);
    }
  }
}

// A soft body of the scene's own vertices, in the order of VerticesOf.
base::Result<SoftBody> BodyOf(const Scene& scene, std::uint32_t object) {
  const RestObject rest = RestOf(scene, object);
  std::vector<DrawnTriangle> triangles;
  DrawnTriangles(scene, object, triangles);
  SoftBuildReport report;
  return BuildSoftBody(rest.vertices_base_m, triangles, SmallOptions(), report);
}

TEST(SurfaceFrame, SoftBodyVerticesMatchSoftDisplacement) {
  Scene scene = Built(TwoBalls());
  auto live = std::make_shared<LiveParts>();
  auto body = BodyOf(scene, 0);
  ASSERT_TRUE(body.ok()) << body.error();
  live->SetSoftBody(0, std::make_unique<const SoftBody>(std::move(*body)));
  scene.SetLive(live);
  EXPECT_EQ(ChangingObjects(scene),
            (std::vector<ChangingObject>{{.object = 0, .soft = true}, {.object = 1, .moved = true}}));

  State state;
  state.soft[2].object = 0;
  const SoftContact contact{.touching = true, .point_base_m = {0, 0, 0.03}, .normal = {0, 0, 1}, .depth_m = 0.003};
  const SoftBodyView view = live->soft_body(0)->view();
  for (int tick = 0; tick < 50; ++tick) (void)support::StepSoftContact(view, contact, kTip_m, 1e-3, state.soft[2].body);
  RestObject rest = RestOf(scene, 0);
  std::vector<DrawnVertex> drawn;
  const double largest_m = DisplacedVertices(scene, {state.soft, state.regions}, rest, drawn);
  EXPECT_GT(largest_m, 1e-4);
  EXPECT_LT(largest_m, 0.01);
  double farthest_m = 0;
  for (std::uint32_t v = 0; v < rest.range.count; ++v) {
    const Vec3 moved = PlaceOf(drawn[v]) - rest.vertices_base_m[v];
    farthest_m = std::max(farthest_m, Norm(moved));
    const Vec3 expected = SoftDisplacement(view, state.soft[2].body, rest.vertices_base_m[v]);
    ASSERT_LT(Norm(moved - expected), 1e-3 * largest_m + 1e-7) << "vertex " << v;
  }
  EXPECT_NEAR(farthest_m, largest_m, 1e-6);

  state.soft[2].object = kNoIndex;  // released: at rest
  EXPECT_EQ(DisplacedVertices(scene, {state.soft, state.regions}, rest, drawn), 0);
}

// A soft body of another mesh displaces nothing.
TEST(SurfaceFrame, SoftBodyOfAnotherMeshIsIgnored) {
  Scene scene = Built(BlockWithTop());
  auto live = std::make_shared<LiveParts>();
  auto body = BuildSmall(SoftBallMesh(), SmallOptions());
  ASSERT_TRUE(body.ok());
  live->SetSoftBody(0, std::make_unique<const SoftBody>(std::move(*body)));
  scene.SetLive(live);
  State state;
  state.soft[0].object = 0;
  RestObject rest = RestOf(scene, 0);
  std::vector<DrawnVertex> drawn;
  EXPECT_EQ(DisplacedVertices(scene, {state.soft, state.regions}, rest, drawn), 0);
}

// The compact surface equals the editor's own snapshot, to the rounding of a float, after random strokes.
TEST(SurfaceFrame, CompactSurfaceMatchesTheEditorSnapshot) {
  const auto editor = sculpt::EditorOf(sculpt::BumpyBall(10, 0.03));
  ASSERT_NE(editor, nullptr);
  Random random(8);
  sculpt::Brush brush;
  std::vector<DrawnVertex> vertices;
  std::vector<DrawnTriangle> triangles;
  for (int k = 0; k < 40; ++k) {
    brush.radius_m = random.Uniform(0.003, 0.01);
    (void)editor->Stroke(sculpt::On(*editor, random.InBox(0.05)), brush, random.Uniform(-0.002, 0.002));
    if (k % 5 == 4) editor->Undo();
    editor->Publish();
    const sculpt::SculptTable* table = editor->publisher().Pin();
    ASSERT_NE(table, nullptr);
    CompactSurface(*table, vertices, triangles);
    editor->publisher().Unpin();
    const Mesh mesh = editor->Snapshot();
    ASSERT_EQ(vertices.size(), mesh.vertices.size());
    ASSERT_EQ(triangles, mesh.triangles);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      ASSERT_LT(Norm(PlaceOf(vertices[v]) - mesh.vertices[v]), 1e-8);
    }
    // Closed: every directed edge has its opposite.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const DrawnTriangle& t : triangles) {
      for (std::size_t e = 0; e < 3; ++e) ++edges[{t[e], t[(e + 1) % 3]}];
    }
    for (const auto& [edge, count] : edges) {
      ASSERT_EQ(count, 1);
      ASSERT_EQ(edges.count({edge.second, edge.first}), 1U);
    }
  }
}

}  // namespace test_haptics_surface_frame
}  // namespace omni::haptics
