// The estimate from a file's counts is an upper bound of what loading takes, and less than twice of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>

#include "service/scene/build_estimate.h"
#include "service/scene/load_scene.h"
#include "service/scene/scene_reader.h"
#include "tests/scene/compressed.h"
#include "tests/scene/files.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/bombs.h"
#include "tests/support/mesh_bombs.h"
#include "tests/support/process/measured_child.h"

namespace omni::scene::test {
namespace test_scene_estimate {

constexpr double kLoose = 2.0;

struct Measured {
  double kept = 0, peak = 0;  // bytes
  std::uint32_t triangles = 0;
};

// What the heap had in use, reserved or written: what the limit of a builder's address space counts.
Measured Load(const std::string& path, const LoadOptions& options) {
  Measured measured;
  LoadReport load;
  haptics::BuildReport build;
  const loop::HeapPeak peak;
  auto scene = LoadScene(path, options, nullptr, load, build);
  if (scene.ok() && !scene->empty()) LoadLive(*scene, nullptr);
  measured.peak = static_cast<double>(peak.bytes());
  if (scene.ok()) measured.kept = static_cast<double>(scene->bytes());
  if (scene.ok() && !scene->empty()) measured.triangles = scene->header().triangle_count;
  return measured;
}

// Nothing: the file is refused.
std::optional<SceneCounts> CountsOf(const std::string& path, const LoadOptions& options) {
  LoadReport report;
  try {
    return SceneReader(path, options, report).Count();
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

// Not much too large where repair drops little, from `large` triangles on.
void ExpectBound(const std::string& name, const std::string& path, const LoadOptions& options, std::uint32_t large) {
  SCOPED_TRACE(name);
  const std::optional<SceneCounts> counts = CountsOf(path, options);
  const Measured measured = Load(path, options);
  if (!counts) {
    EXPECT_EQ(measured.kept, 0);
    return;
  }
  const BuildEstimate estimate = EstimateBuild(*counts);
  const auto kept = static_cast<double>(estimate.kept_bytes), peak = static_cast<double>(estimate.peak_bytes);
  EXPECT_GE(kept, measured.kept);
  EXPECT_GE(peak, measured.peak);
  if (measured.triangles < large) return;
  const auto live = [](const ObjectCounts& object) { return object.soft || object.sculpted; };
  if (std::none_of(counts->objects.begin(), counts->objects.end(), live)) {
    EXPECT_LT(kept, kLoose * measured.kept);  // of the block
    EXPECT_LT(peak, kLoose * measured.peak);
  }
  if (std::getenv("OMNI_SHOW") != nullptr)
    std::printf("%-26s kept %8.2f MB, at most %8.2f; peak %8.2f, at most %8.2f\n", name.c_str(), 1e-6 * measured.kept,
                1e-6 * kept, 1e-6 * measured.peak, 1e-6 * peak);
}

TEST(BuildEstimate, IsAnUpperBoundForMeshes) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  const TempFolder folder;
  const auto check = [&](const omni::test::MeshBomb& bomb) {
    const std::string path = folder.Write("mesh.glb", omni::test::MeshFile(bomb.make(60'000)));
    ExpectBound(bomb.name, path, {}, 50'000);
  };
  check(omni::test::kCleanMesh);
  for (const omni::test::MeshBomb& bomb : omni::test::kMeshBombs) check(bomb);
}

Model ModelOf(const std::string& glb) {
  std::uint32_t json_bytes = 0;
  std::memcpy(&json_bytes, &glb[12], sizeof json_bytes);
  return {Json::parse(glb.substr(20, json_bytes)), glb.substr(28 + json_bytes)};
}

// Decoded whole, beside what is made of it.
TEST(BuildEstimate, IsAnUpperBoundForCompressedMeshes) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  const TempFolder folder;
  const auto soup = omni::test::meshes::CleanBall(60'000);
  const std::size_t vertices = soup.vertices_base_m.size();
  const Model plain = ModelOf(omni::test::MeshFile(soup));
  const std::string positions = plain.bin.substr(0, 12 * vertices);
  std::vector<unsigned> corners;
  for (const auto& triangle : soup.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  Model meshopt = plain;
  meshopt.bin.clear();
  Compress(meshopt, 0, MeshoptVertices(positions, 12), vertices, 12, "ATTRIBUTES");
  Compress(meshopt, 1, MeshoptIndices(corners, true), corners.size(), 4, "TRIANGLES");
  ExpectBound("meshopt", folder.Write("meshopt.glb", meshopt.Bytes()), {}, 50'000);
  const std::vector<DracoAttribute> attributes{
      {"POSITION", draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, positions}};
  for (const bool edgebreaker : {false, true}) {
    for (const int bits : {0, 14}) {
      Model compressed = plain;
      compressed.bin.clear();
      UseDraco(compressed, EncodeDraco(soup.triangles, vertices, attributes, edgebreaker, bits), attributes);
      ExpectBound(edgebreaker ? "draco edgebreaker" : "draco sequential", folder.Write("draco.glb", compressed.Bytes()),
                  {}, 50'000);
    }
  }
}

TEST(BuildEstimate, IsAnUpperBoundForSkinsAndMorphTargets) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  const TempFolder folder;
  const auto soup = omni::test::meshes::CleanBall(60'000);
  const std::size_t vertices = soup.vertices_base_m.size();
  Model model = ModelOf(omni::test::MeshFile(soup));
  Json& primitive = model.json["meshes"][0]["primitives"][0];
  for (int target = 0; target < 3; ++target) {
    const std::size_t moved = AddAccessor(model, std::string(12 * vertices, '\0'),
                                          {{"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}});
    primitive["targets"].push_back({{"POSITION", moved}});
    model.json["meshes"][0]["weights"].push_back(0.5);
  }
  ExpectBound("morph targets", folder.Write("morph.glb", model.Bytes()), {}, 50'000);
  primitive["attributes"]["JOINTS_0"] = AddAccessor(model, std::string(4 * vertices, '\0'),
                                                    {{"componentType", 5121}, {"count", vertices}, {"type", "VEC4"}});
  primitive["attributes"]["WEIGHTS_0"] = AddAccessor(model, std::string(16 * vertices, '\0'),
                                                     {{"componentType", 5126}, {"count", vertices}, {"type", "VEC4"}});
  model.json["skins"] = Json::array({{{"joints", std::vector<int>(90'000, 0)}}});
  model.json["nodes"][0]["skin"] = 0;
  ExpectBound("skin", folder.Write("skin.glb", model.Bytes()), {}, 50'000);
}

TEST(BuildEstimate, IsAnUpperBoundForShippedScenes) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  for (const char* name : {"extrusion", "dragon", "racetrack"})
    ExpectBound(name, OMNI_SOURCE_DIR "/scenes/" + std::string(name) + ".glb", {}, 10'000);
}

TEST(BuildEstimate, IsAnUpperBoundForHostileDocuments) {
  if (!omni::test::kMemoryCounts) GTEST_SKIP() << "the sanitizer takes memory of its own";
  const TempFolder folder;
  for (const omni::test::Bomb& bomb : omni::test::kSceneBombs)
    ExpectBound(bomb.name, folder.Write("bomb.gltf", bomb.make(1'000'000)), kTouchAll, UINT32_MAX);
}

TEST(BuildEstimate, CountsWhatTheFileHas) {
  const TempFolder folder;
  const auto soup = omni::test::meshes::CleanBall(1000);
  const auto ball = CountsOf(folder.Write("ball.glb", omni::test::MeshFile(soup)), {});
  ASSERT_TRUE(ball);
  ASSERT_EQ(ball->objects.size(), 1U);
  EXPECT_EQ(ball->objects[0].triangles, soup.triangles.size());
  EXPECT_EQ(ball->objects[0].vertices, soup.vertices_base_m.size());
  EXPECT_EQ(ball->mesh_bytes, 12 * (soup.vertices_base_m.size() + soup.triangles.size()));
  EXPECT_FALSE(ball->objects[0].soft);
  const auto dragon = CountsOf(OMNI_SOURCE_DIR "/scenes/dragon.glb", {});
  ASSERT_TRUE(dragon);
  EXPECT_TRUE(dragon->objects.at(0).soft);
  Model plain = Tetra();  // without a tag: nothing is touched
  const auto untagged = CountsOf(folder.Write("plain.glb", plain.Bytes()), {});
  ASSERT_TRUE(untagged);
  EXPECT_TRUE(untagged->objects.empty());
  const auto touched = CountsOf(folder.Write("plain.glb", plain.Bytes()), kTouchAll);
  ASSERT_TRUE(touched);
  EXPECT_EQ(touched->objects.size(), 1U);
  EXPECT_FALSE(CountsOf(folder.Write("bad.glb", "no glTF"), {}));
}

}  // namespace test_scene_estimate
}  // namespace omni::scene::test
