// Meshes that are meant to cost as much as they can are built at a cost like that of a clean one, and what is not
// looked at is said.
#include <gtest/gtest.h>

#include <time.h>

#include "service/haptics/geometry/mesh_repair.h"
#include "tests/haptics/scenario.h"
#include "tests/support/mesh_bombs.h"

namespace omni::haptics {
namespace test_repair_bounds {

using omni::test::kCleanMesh;
using omni::test::kMeshBombs;
using omni::test::MeshBomb;

double BuildCpu_s(const InputObject& object) {
  const SceneInput input = SceneOf(object);
  BuildReport report;
  const auto now_s = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);  // what others do on the machine does not count
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double start_s = now_s();
  EXPECT_TRUE(BuildScene(input, report).ok());
  return now_s() - start_s;
}

// Was 200 to 2000 times, and 250 triangles of each one that was given.
TEST(MeshBounds, AnyMeshCostsAboutAsMuchAsACleanOne) {
  constexpr std::size_t kTriangles = 8000;
  for (const MeshBomb& bomb : kMeshBombs) {
    const InputObject object = bomb.make(kTriangles), clean = kCleanMesh.make(object.triangles.size());
    double ratio = BuildCpu_s(object) / BuildCpu_s(clean);
    for (int i = 0; i < 4 && ratio > 30; ++i) ratio = std::min(ratio, BuildCpu_s(object) / BuildCpu_s(clean));
    EXPECT_LT(ratio, 30) << bomb.name;
    EXPECT_LT(Built(SceneOf(object)).triangles().size(), 2 * object.triangles.size() + 1000) << bomb.name;
  }
}

// Work of a build by its own count (base::WorkWatch), per triangle.
double WorkPerTriangle(const MeshBomb& bomb, std::size_t triangles) {
  const InputObject object = bomb.make(triangles);
  const base::WorkWatch watch;
  BuildReport report;
  EXPECT_TRUE(BuildScene(SceneOf(object), report, watch).ok()) << bomb.name;
  return static_cast<double>(watch.done()) / static_cast<double>(object.triangles.size());
}

// Growth faster than the number of triangles is found without a clock. From 20,000 on the large holes are small enough,
// of the whole, to be closed.
TEST(MeshBounds, WorkGrowsWithTheNumberOfTriangles) {
  for (const MeshBomb& bomb : kMeshBombs) {
    const double few = WorkPerTriangle(bomb, 20'000), many = WorkPerTriangle(bomb, 80'000);
    EXPECT_LE(many, 1.5 * few) << bomb.name << ": " << few << " and " << many;
  }
}

double Volume(const Mesh& mesh, std::uint32_t component) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (mesh.component[t] == component) sum += Dot(mesh.vertices[a], Cross(mesh.vertices[b], mesh.vertices[c])) / 6;
  }
  return sum;
}

// More balls through each other than can be asked about: the volume of each decides, and a line says so.
TEST(MeshBounds, VolumesDecideWhatWouldTakeTooLongToAsk) {
  const InputObject balls = omni::test::meshes::TurnedBalls(8000);
  RepairCounts counts;
  Mesh mesh = RepairMesh(balls, counts);
  const TopologyReport topology = ConnectAndOrient(mesh);
  ASSERT_GT(topology.components, 100U);
  EXPECT_GT(topology.by_volume, 0U);
  EXPECT_EQ(topology.flipped_components, topology.components);
  for (std::uint32_t c = 0; c < topology.components; ++c) ASSERT_GT(Volume(mesh, c), 0) << c;
  BuildReport report;
  ASSERT_TRUE(BuildScene(SceneOf(balls), report).ok());
  EXPECT_TRUE(std::any_of(report.lines.begin(), report.lines.end(), [](const std::string& line) {
    return line.find("turned by their own volumes") != std::string::npos;
  })) << testing::PrintToString(report.lines);
}

// Few parts are all asked, and no line says otherwise: a solid in a solid in a crowd of leaves.
TEST(MeshBounds, LeavesAreNotAsked) {
  InputObject object = omni::test::meshes::LooseTriangles(2000);
  omni::test::meshes::Ball(object, {0, 0, 0.05}, 0.02, 8, true);
  omni::test::meshes::Ball(object, {0, 0, 0.05}, 0.01, 8, false);
  RepairCounts counts;
  Mesh mesh = RepairMesh(object, counts);
  const TopologyReport topology = ConnectAndOrient(mesh);
  EXPECT_EQ(topology.by_volume, 0U);
  EXPECT_EQ(topology.flipped_components, 1U);
  for (std::uint32_t c = topology.components - 2; c < topology.components; ++c) EXPECT_GT(Volume(mesh, c), 0) << c;
}

// A vertex on so many edges that splitting all of them would make a file of kilobytes one of millions of triangles.
TEST(MeshBounds, SplittingEdgesDoesNotMultiplyTriangles) {
  BuildReport report;
  const InputObject crowd = omni::test::meshes::Junctions(4000);
  const auto scene = BuildScene(SceneOf(crowd), report);
  ASSERT_TRUE(scene.ok());
  EXPECT_LT(scene->triangles().size(), 2 * crowd.triangles.size());
  EXPECT_TRUE(std::any_of(report.lines.begin(), report.lines.end(), [](const std::string& line) {
    return line.find("not split at the vertices on them") != std::string::npos;
  })) << testing::PrintToString(report.lines);
}

TEST(MeshBounds, EqualInputsGiveEqualBits) {
  for (const MeshBomb& bomb : kMeshBombs) {
    const Scene a = Built(SceneOf(bomb.make(2000))), b = Built(SceneOf(bomb.make(2000)));
    EXPECT_TRUE(std::equal(a.block().begin(), a.block().end(), b.block().begin(), b.block().end())) << bomb.name;
  }
}

}  // namespace test_repair_bounds
}  // namespace omni::haptics
