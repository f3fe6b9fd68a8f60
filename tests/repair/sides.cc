// Bodies as people's meshes have them: what is in the body is felt, and nothing outside of it is.
#include <gtest/gtest.h>

#include "service/haptics/geometry/mesh_repair.h"
#include "tests/support/touch/side_judge.h"

namespace omni::haptics {
namespace test_repair_sides {

using namespace broken;

// Was: thousands of ticks missed and false for each broken body, because what was not closed was felt from both sides
// and had no side.
TEST(Sides, PointAndBallFeelBrokenBodiesAsWholeOnes) {
  for (const Broken& broken : BrokenBodies(2, true)) {
    for (const double radius_m : {0.0, 1e-3}) {
      const SideCounts counts = Stroke(broken, radius_m, 6, 2);
      SCOPED_TRACE(broken.body + ", " + broken.defect + (radius_m > 0 ? ", ball" : ", point"));
      EXPECT_GT(counts.inside, 100U);
      EXPECT_EQ(counts.missed, 0U);
      EXPECT_EQ(counts.false_contacts, 0U);
    }
  }
}

TopologyReport Repaired(const InputObject& object) {
  RepairCounts counts;
  Mesh mesh = RepairMesh(object, counts);
  return ConnectAndOrient(mesh);
}

// Was 1,259 sheets.
TEST(Sides, CracksThatNobodyFeelsAreWelded) {
  for (const double w : {7e-9, 1e-7, 1e-6, 5e-6, 1e-5}) {
    const TopologyReport topology = Repaired(Jittered(BallBody1280(), w, 3).object);
    EXPECT_TRUE(topology.IsClosed()) << w << " " << topology.border_edges;
    EXPECT_EQ(topology.components, 1U) << w;
    EXPECT_LE(topology.stitched_within_m, 1e-5) << w;
  }
  // Cracks that can be felt, and triangles that are small beside their cracks, stay as they are.
  EXPECT_EQ(Repaired(Shrunk(BallBody1280(), 5e-5).object).stitched, 0U);
  const Body tiny{"tiny", Icosphere(3, 2e-4), {}};
  EXPECT_EQ(Repaired(Shrunk(tiny, 1e-5).object).components, 1280U);
}

// Both used to stay open, and with them the body.
TEST(Sides, HolesThatShareAVertexAreFilledOneByOne) {
  const Broken broken = HolesInPairs(BoxBody(), 12, 4);
  const TopologyReport topology = Repaired(broken.object);
  EXPECT_TRUE(topology.IsClosed());
  EXPECT_EQ(topology.closed_holes, 24U);
}

bool Says(const InputObject& object, const char* words) {
  BuildReport report;
  EXPECT_TRUE(BuildScene(SceneOf(object), report).ok());
  return std::any_of(report.lines.begin(), report.lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

InputObject Without(const InputObject& object, const std::function<bool(const Vec3& centroid)>& gone) {
  InputObject left = object;
  left.triangles.clear();
  left.triangle_material.clear();
  for (std::size_t t = 0; t < object.triangles.size(); ++t) {
    const auto& [a, b, c] = object.triangles[t];
    if (!gone((1.0 / 3) * (Corner(object, t, 0) + Corner(object, t, 1) + Corner(object, t, 2))))
      AddTriangle(left, a, b, c);
  }
  return left;
}

// As of a scanned figure: a large hole stays, the small ones do not stay with it. A sheet keeps its own.
TEST(Sides, ALargeHoleDoesNotKeepSmallOnesOpen) {
  const InputObject ball = Icosphere(4, 0.015);
  const auto small = [](const Vec3& c) { return std::hypot(c.x, c.y - 0.01) < 0.0015 || std::hypot(c.x, c.z) < 0.001; };
  const InputObject figure = Without(ball, [&](const Vec3& c) { return c.z < -0.012 || small(c); });
  const TopologyReport topology = Repaired(figure);
  EXPECT_FALSE(topology.IsClosed());
  EXPECT_GE(topology.closed_holes, 3U);
  EXPECT_TRUE(Says(figure, "felt as a solid with cracks or openings"));
  const InputObject bowl = Without(ball, [&](const Vec3& c) { return c.z > 0 || small(c); });
  EXPECT_EQ(Repaired(bowl).closed_holes, 0U);
  EXPECT_TRUE(Says(bowl, "felt from both sides, as a sheet"));
}

// Loose triangles that all face inwards are turned by their winding number; a crowd of leaves is not.
TEST(Sides, LooseTrianglesFaceOutwards) {
  InputObject soup = Soup(BoxBody(), 5).object;
  for (auto& t : soup.triangles) std::swap(t[1], t[2]);
  EXPECT_GT(Repaired(soup).solidity, 0.4);
}

TEST(Sides, ExplainSaysWhatAPersonWillFeel) {
  EXPECT_TRUE(Says(BoxBody().object, "felt as a closed solid"));
  EXPECT_TRUE(Says(Jittered(BoxBody(), 5e-6, 1).object, "welded over cracks, within 10 um"));
  EXPECT_TRUE(Says(Jittered(BoxBody(), 5e-6, 1).object, "felt as a closed solid"));
  EXPECT_TRUE(Says(Soup(BoxBody(), 1).object, "felt as a solid with cracks or openings"));
  InputObject sheet;
  sheet.vertices_base_m = {{-0.01, -0.01, 0}, {0.01, -0.01, 0}, {0, 0.01, 0}};
  AddTriangle(sheet, 0, 1, 2);
  EXPECT_TRUE(Says(sheet, "felt from both sides, as a sheet"));
}

}  // namespace test_repair_sides
}  // namespace omni::haptics
