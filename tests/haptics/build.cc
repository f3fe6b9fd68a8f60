// BuildScene: repairs, errors and reports.
#include <gtest/gtest.h>

#include <limits>

#include "service/haptics/geometry/query.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_haptics_build {

bool Says(const BuildReport& report, const std::string& words) {
  for (const std::string& line : report.lines) {
    if (line.find(words) != std::string::npos) return true;
  }
  return false;
}

InputObject SmallBlock() { return Block(3, {0.02, 0.02, 0.02}); }

// Pressing on the top gives a contact, beside it does not.
void ExpectSolid(const Scene& scene) {
  ASSERT_FALSE(scene.empty());
  Pen pen(scene);
  pen.Slide({0.003, 0.004, 0.025}, {0.003, 0.004, 0.018}, 50);
  EXPECT_EQ(pen.output.contact_count, 1);
  EXPECT_GT(pen.output.force_base_N.z, 0.5);
  pen.Slide({0.003, 0.004, 0.018}, {0.003, 0.004, 0.025}, 50);
  EXPECT_EQ(pen.output.contact_count, 0);
}

TEST(BuildScene, WeldsABlockIntoOneClosedObject) {
  BuildReport report;
  const auto scene = BuildScene(SceneOf(SmallBlock()), report);
  ASSERT_TRUE(scene.ok()) << scene.error();
  EXPECT_EQ(scene->header().triangle_count, 108U);
  EXPECT_EQ(scene->header().vertex_count, 56U);  // 6 x 16 with shared edges and corners
  EXPECT_EQ(report.welded_vertices, 96U - 56U);
  EXPECT_EQ(scene->objects()[0].flags, std::uint32_t{kClosed | kCollidable});
  for (const Triangle& t : scene->triangles()) {
    for (const std::uint32_t n : t.neighbour) EXPECT_NE(n, kNoIndex);
  }
  ExpectSolid(*scene);
}

TEST(BuildScene, WeldsAlmostEqualVertices) {
  InputObject block = SmallBlock();
  Random random(1);
  for (Vec3& v : block.vertices_base_m) v = v + random.InBox(1e-9);
  const Scene scene = Built(SceneOf(block));
  ASSERT_FALSE(scene.empty());
  EXPECT_EQ(scene.header().vertex_count, 56U);
  ExpectSolid(scene);
}

TEST(BuildScene, WeldsATriangleSoup) {
  const InputObject block = SmallBlock();
  InputObject soup;
  for (const auto& t : block.triangles) {
    const auto base = static_cast<std::uint32_t>(soup.vertices_base_m.size());
    for (const std::uint32_t v : t) soup.vertices_base_m.push_back(block.vertices_base_m[v]);
    AddTriangle(soup, base, base + 1, base + 2);
  }
  ExpectSolid(Built(SceneOf(soup)));
}

TEST(BuildScene, ReorientsInsideOutAndHalfFlippedMeshes) {
  InputObject inside_out = SmallBlock();
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  BuildReport report;
  auto scene = BuildScene(SceneOf(inside_out), report);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(report.flipped_objects, 1U);
  EXPECT_TRUE(Says(report, "inside-out"));
  ExpectSolid(*scene);

  InputObject half = SmallBlock();
  Random random(7);
  for (auto& t : half.triangles) {
    if (random.Next() % 2 == 0) std::swap(t[1], t[2]);
  }
  scene = BuildScene(SceneOf(half), report);
  ASSERT_TRUE(scene.ok());
  EXPECT_TRUE(Says(report, "agree with their neighbours"));
  ExpectSolid(*scene);
}

TEST(BuildScene, KeepsACavity) {
  InputObject hollow = Block(2, {0.02, 0.02, 0.02});
  const InputObject inner = Block(2, {0.01, 0.01, 0.01});
  const auto base = static_cast<std::uint32_t>(hollow.vertices_base_m.size());
  hollow.vertices_base_m.insert(hollow.vertices_base_m.end(), inner.vertices_base_m.begin(),
                                inner.vertices_base_m.end());
  for (const auto& t : inner.triangles) AddTriangle(hollow, base + t[0], base + t[2], base + t[1]);
  BuildReport report;
  const auto scene = BuildScene(SceneOf(hollow), report);
  ASSERT_TRUE(scene.ok());
  EXPECT_TRUE(Says(report, "cavities kept"));
  Pen pen(*scene);
  pen.MoveTo({});
  EXPECT_EQ(pen.output.contact_count, 0) << "the middle of the cavity is outside";
  pen.Slide({}, {0, 0, 0.012}, 20);
  EXPECT_LT(pen.output.force_base_N.z, -0.1) << "its ceiling pushes down";
}

TEST(BuildScene, DropsAndReportsBadTriangles) {
  InputObject block = SmallBlock();
  const auto n = static_cast<std::uint32_t>(block.vertices_base_m.size());
  block.vertices_base_m.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  block.vertices_base_m.push_back({0, std::numeric_limits<double>::infinity(), 0});
  AddTriangle(block, 0, 1, n);
  AddTriangle(block, 0, 1, n + 1);
  AddTriangle(block, 0, 0, 1);
  AddTriangle(block, block.triangles[0][1], block.triangles[0][2], block.triangles[0][0]);
  BuildReport report;
  const auto scene = BuildScene(SceneOf(block), report);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(report.dropped_triangles, 4U);
  EXPECT_TRUE(Says(report, "2 triangles dropped: coordinates not finite"));
  EXPECT_TRUE(Says(report, "1 triangles dropped: no area"));
  EXPECT_TRUE(Says(report, "1 triangles dropped: duplicates"));
  ExpectSolid(*scene);
}

TEST(BuildScene, MakesOpenMeshesDoubleSided) {
  InputObject open = SmallBlock();
  open.triangles.resize(90);  // without most of the last face
  open.triangle_material.resize(90);
  BuildReport report;
  const auto scene = BuildScene(SceneOf(open), report);
  ASSERT_TRUE(scene.ok());
  EXPECT_TRUE(Says(report, "the mesh is open"));
  EXPECT_EQ(scene->objects()[0].flags & (kClosed | kDoubleSided), std::uint32_t{kDoubleSided});
  ExpectSolid(*scene);
}

TEST(BuildScene, AcceptsNonManifoldMeshes) {
  InputObject fins = SmallBlock();
  const auto n = static_cast<std::uint32_t>(fins.vertices_base_m.size());
  const auto t = fins.triangles[0];
  fins.vertices_base_m.push_back({0.04, 0.03, 0.03});
  AddTriangle(fins, t[0], t[1], n);
  BuildReport report;
  const auto scene = BuildScene(SceneOf(fins), report);
  ASSERT_TRUE(scene.ok());
  EXPECT_TRUE(Says(report, "three or more triangles"));
  ExpectSolid(*scene);
}

TEST(BuildScene, CutsAMoebiusStrip) {
  InputObject strip;
  constexpr std::uint32_t kCount = 24;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double u = 2 * std::numbers::pi * i / kCount;
    for (const double w : {-0.005, 0.005}) {
      const double r = 0.03 + w * std::cos(u / 2);
      strip.vertices_base_m.push_back({r * std::cos(u), r * std::sin(u), w * std::sin(u / 2)});
    }
  }
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::uint32_t a = 2 * i, b = a + 1;
    const std::uint32_t c = i + 1 < kCount ? a + 2 : 1, d = i + 1 < kCount ? a + 3 : 0;
    AddTriangle(strip, a, c, b);
    AddTriangle(strip, b, c, d);
  }
  BuildReport report;
  ASSERT_TRUE(BuildScene(SceneOf(strip), report).ok());
  EXPECT_TRUE(Says(report, "no consistent orientation"));
}

struct Refusal {
  const char* words;
  std::function<void(SceneInput&)> spoil;
};

TEST(BuildScene, RejectsInvalidInputNamingTheField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Refusal refusals[] = {
      {"no triangles", [](SceneInput& s) { s.objects.clear(); }},
      {"no materials", [](SceneInput& s) { s.materials.clear(); }},
      {"65 objects, the limit is 64", [](SceneInput& s) { s.objects.resize(65); }},
      {"uses material 9 of 1", [](SceneInput& s) { s.objects[0].triangle_material[5] = 9; }},
      {"uses vertex 99999", [](SceneInput& s) { s.objects[0].triangles[5][1] = 99999; }},
      {"the limit is 10 m", [](SceneInput& s) { s.objects[0].vertices_base_m[3].y = 1e30; }},
      {"the limit is 10 m", [](SceneInput& s) { s.objects[0].vertices_base_m[3].y = -10.5; }},
      {"materials for", [](SceneInput& s) { s.objects[0].triangle_material.pop_back(); }},
      {"none of its triangles is finite",
       [=](SceneInput& s) {
         s.objects[0].vertices_base_m.assign(s.objects[0].vertices_base_m.size(), Vec3{nan, 0, 0});
       }},
      {"joystick", [](SceneInput& s) { s.joystick.emplace().range_m = 0; }},
      {"wheelbase_m", [](SceneInput& s) { s.vehicle.emplace().wheelbase_m = 0; }},
      {"extrude.step", [](SceneInput& s) { s.materials[0].extrude = {true, 0, 1, 1, 0.5, 0.2}; }},
      {"stiffness", [=](SceneInput& s) { s.materials[0].stiffness_N_m = nan; }},
  };
  for (const Refusal& refusal : refusals) {
    SceneInput input = SceneOf(SmallBlock());
    refusal.spoil(input);
    BuildReport report;
    const auto scene = BuildScene(input, report);
    ASSERT_FALSE(scene.ok()) << refusal.words;
    EXPECT_NE(scene.error().find(refusal.words), std::string::npos) << scene.error();
  }
}

TEST(BuildScene, RejectsMoreTrianglesThanTheLimit) {
  SceneInput input = SceneOf(SmallBlock());
  input.objects[0].triangles.resize(kMaxTriangles + 1, {0, 1, 2});
  input.objects[0].triangle_material.resize(kMaxTriangles + 1, 0);
  BuildReport report;
  const auto scene = BuildScene(input, report);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().find("4000001 triangles, the limit is 4000000"), std::string::npos) << scene.error();
}

TEST(BuildScene, FindsOneRegionPerSideOfAnExtrudableBlock) {
  Material clay;
  clay.extrude.enabled = true;
  BuildReport report;
  const auto scene = BuildScene(SceneOf(Block(4, {0.03, 0.02, 0.01}), clay), report);
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->header().region_count, 6U);
  const Region& top = scene->regions()[0];  // largest first
  EXPECT_NEAR(std::abs(top.normal.z), 1, 1e-12);
  EXPECT_NEAR(std::abs(top.centroid_base_m.z), 0.01, 1e-12);
  EXPECT_NEAR(top.radius_m, std::hypot(0.03, 0.02), 1e-12);
  // The tree allows for every offset.
  EXPECT_GE(scene->objects()[0].upper_base_m[2], 0.01 + clay.extrude.step_m);
}

}  // namespace test_haptics_build
}  // namespace omni::haptics
