// How valid files load.
#include <gtest/gtest.h>

#include <cmath>

#include "service/haptics/scene/scene.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_load {

TEST(SceneLoad, ConvertsToTheBaseFrame) {
  Loaded loaded = LoadBytes(Tetra().Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  ASSERT_EQ(loaded.scene().objects.size(), 1U);
  const haptics::InputObject& object = loaded.scene().objects[0];
  EXPECT_EQ(object.name, "tetra");
  EXPECT_EQ(object.triangles.size(), 4U);
  EXPECT_EQ(object.vertices_base_m.size(), 4U);
  EXPECT_NEAR(SignedVolume6(object), 1e-6, 1e-12);
  EXPECT_EQ(object.triangle_material, std::vector<std::uint16_t>(4, 0));
  EXPECT_EQ(loaded.scene().materials.size(), 1U);
  EXPECT_EQ(loaded.scene().name, "model");
  // glTF (0, 0.045, 0.01) is 45 mm up and 10 mm towards the viewer: -y in the base frame.
  bool found = false;
  for (const base::Vec3& p : object.vertices_base_m) {
    found = found || (std::abs(p.x) < 1e-9 && std::abs(p.y + 0.01) < 1e-8 && std::abs(p.z - 0.045) < 1e-8);
  }
  EXPECT_TRUE(found);
}

TEST(SceneLoad, ParentTransformsApplyAndMirroringKeepsOrientation) {
  Model model = Tetra();
  model.json["nodes"] = Json::parse(R"([{"children": [1], "translation": [0.1, 0, 0]},
    {"children": [2], "rotation": [0, 0.70710678, 0, 0.70710678]}, {"mesh": 0, "name": "deep", "scale": [-2, 2, 2]}])");
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 8e-6, 1e-10);
  double lowest_x = 1;
  for (const base::Vec3& p : loaded.scene().objects[0].vertices_base_m) lowest_x = std::min(lowest_x, p.x);
  EXPECT_NEAR(lowest_x, 0.1, 1e-7);  // the rotation turns the mesh's z (0 to 0.02) to +x
}

TEST(SceneLoad, MatrixIsColumnMajor) {
  Model model = Tetra();
  model.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.25, 0.5, 0.75, 1};
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  const base::Vec3 p = loaded.scene().objects[0].vertices_base_m[0];
  EXPECT_NEAR(p.x, 0.25, 1e-7);
  EXPECT_NEAR(p.y, -0.75, 1e-7);
  EXPECT_NEAR(p.z, 0.545, 1e-7);
}

TEST(SceneLoad, StripsAndFansWindLikeTriangles) {
  Model model = Tetra();
  model.bin = Bytes(TetraPositions()) + Bytes(std::vector<std::uint16_t>{0, 2, 1, 3, 0, 2, 0, 0, 0, 0, 0, 0});
  model.json["meshes"][0]["primitives"][0]["mode"] = 5;
  model.json["accessors"][1]["count"] = 6;
  Loaded strip = LoadBytes(model.Bytes());
  ASSERT_TRUE(strip.result.ok()) << strip.result.error();
  EXPECT_EQ(strip.scene().objects[0].triangles.size(), 4U);
  EXPECT_NEAR(SignedVolume6(strip.scene().objects[0]), 1e-6, 1e-12);

  model.bin = Bytes(TetraPositions()) + Bytes(std::vector<std::uint16_t>{0, 2, 1, 3, 2, 0, 0, 0, 0, 0, 0, 0});
  model.json["meshes"][0]["primitives"][0]["mode"] = 6;
  model.json["accessors"][1]["count"] = 5;
  Loaded fan = LoadBytes(model.Bytes());
  ASSERT_TRUE(fan.result.ok()) << fan.result.error();
  EXPECT_EQ(fan.scene().objects[0].triangles.size(), 3U);
}

TEST(SceneLoad, PointsAndLinesAreSkippedAndExplained) {
  Model model = Tetra();
  Json lines = model.json["meshes"][0]["primitives"][0];
  lines["mode"] = 1;
  model.json["meshes"][0]["primitives"].push_back(lines);
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_EQ(loaded.scene().objects[0].triangles.size(), 4U);
  bool explained = false;
  for (const ExplainRow& row : loaded.report.rows)
    explained = explained || (row.pointer == "/meshes/0/primitives/1" && !row.loaded);
  EXPECT_TRUE(explained);
}

TEST(SceneLoad, NonIndexedVerticesFormTriangles) {
  Model model = Tetra();
  std::vector<float> positions;
  for (const std::uint16_t i : TetraIndices()) {
    for (std::size_t k = 0; k < 3; ++k) positions.push_back(TetraPositions()[3 * i + k]);
  }
  model.bin = Bytes(positions);
  model.json["meshes"][0]["primitives"][0].erase("indices");
  model.json["accessors"][0]["count"] = 12;
  model.json["bufferViews"][0]["byteLength"] = model.bin.size();
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 1e-6, 1e-12);
}

TEST(SceneLoad, SparseValuesOverrideTheBuffer) {
  Model model = Tetra();
  model.bin += Bytes(std::vector<std::uint8_t>{2, 0, 0, 0}) + Bytes(std::vector<float>{0, 0.065F, 0});
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  model.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 72}, {"byteLength", 4}});
  model.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 76}, {"byteLength", 12}});
  model.json["accessors"][0]["sparse"] =
      Json::parse(R"({"count": 1, "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 3}})");
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 2e-6, 1e-12);
}

TEST(SceneLoad, ReadsQuantisedInterleavedPositions) {
  Model model = Tetra();
  std::vector<std::int16_t> rows;  // x y z and one word of something else
  for (const auto& [x, y, z] : {std::array{0, 0, 0}, {32767, 0, 0}, {0, 32767, 0}, {0, 0, 32767}}) {
    for (const int c : {x, y, z, 77}) rows.push_back(static_cast<std::int16_t>(c));
  }
  model.bin = Bytes(rows) + std::string(16, '\0') + Bytes(TetraIndices());
  model.json["bufferViews"][0]["byteStride"] = 8;
  model.json["accessors"][0]["componentType"] = 5122;
  model.json["accessors"][0]["normalized"] = true;
  model.json["nodes"][0]["scale"] = {0.01, 0.01, 0.01};
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 1e-6, 1e-12);
}

TEST(SceneLoad, ReadsOnlyTheBytesHapticsNeeds) {
  Model model = Tetra();
  model.bin += std::string(1'000'000, 'x');
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  model.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 72}, {"byteLength", 1'000'000}});
  model.json["images"] = Json::array({{{"bufferView", 2}, {"mimeType", "image/png"}}});
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_GT(loaded.report.file_bytes, 1'000'000U);
  EXPECT_LT(loaded.report.bytes_read, 4096U);
  EXPECT_EQ(loaded.report.rows.back().pointer, "/images");
  EXPECT_EQ(loaded.report.rows[0].bytes, 72U);
}

TEST(SceneLoad, ReadsGltfWithDataUriOrExternalBuffer) {
  const TempFolder folder;
  Model model = Tetra();
  model.json["buffers"][0]["uri"] = "tetra%20data.bin";
  folder.Write("tetra data.bin", model.bin);
  Loaded beside = Load(folder.Write("a.gltf", model.json.dump()));
  ASSERT_TRUE(beside.result.ok()) << beside.result.error();
  EXPECT_NEAR(SignedVolume6(beside.scene().objects[0]), 1e-6, 1e-12);

  // 72 bytes of zeros but for one triangle of three corners.
  model.json["buffers"][0] = {{"byteLength", 3}, {"uri", "data:application/octet-stream;base64,AAEC"}};
  model.json["accessors"] = Json::parse(R"([{"componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 0, "componentType": 5121, "count": 3, "type": "SCALAR"}])");
  model.json["bufferViews"] = Json::parse(R"([{"buffer": 0, "byteLength": 3}])");
  Loaded embedded = Load(folder.Write("b.gltf", "\xEF\xBB\xBF" + model.json.dump()));
  ASSERT_TRUE(embedded.result.ok()) << embedded.result.error();
  EXPECT_EQ(embedded.scene().objects[0].triangles.size(), 1U);
}

TEST(SceneLoad, NodesOutsideTheSceneAreNotRead) {
  Model model = Tetra();
  model.json["nodes"].push_back({{"mesh", 0}, {"name", "elsewhere"}});
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_EQ(loaded.scene().objects.size(), 1U);
}

TEST(SceneLoad, ObjectsBeyondTheLimitAreJoined) {
  Model model = Tetra();
  constexpr std::size_t kNodes = 150;
  for (std::size_t i = 1; i < kNodes; ++i) {
    model.json["nodes"].push_back({{"mesh", 0}});
    model.json["scenes"][0]["nodes"].push_back(i);
  }
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_LE(loaded.scene().objects.size(), haptics::kMaxObjects);
  std::size_t triangles = 0;
  for (const haptics::InputObject& object : loaded.scene().objects) {
    triangles += object.triangles.size();
    EXPECT_EQ(object.triangles.size(), object.triangle_material.size());
  }
  EXPECT_EQ(triangles, 4 * kNodes);
}

TEST(SceneLoad, InstancesAreTransformed) {
  Model model = Tetra();
  const std::vector<float> shifts = {0, 0, 0, 0.02F, 0, 0, 0, 0, -0.03F};
  const std::vector<std::int16_t> turns = {0, 0, 0, 32767, 0, 32767, 0, 0, 0, 0, 0, 32767};  // the second: half about y
  const std::vector<float> scales = {1, 1, 1, 1, 1, 1, -2, 2, 2};
  const auto view = [&](const std::string& bytes) {
    model.json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", model.bin.size()}, {"byteLength", bytes.size()}});
    model.bin += bytes;
    return model.json["bufferViews"].size() - 1;
  };
  const auto accessor = [&](std::size_t bytes, int component, const char* type) {
    model.json["accessors"].push_back(
        {{"bufferView", bytes}, {"componentType", component}, {"count", 3}, {"type", type}});
    return model.json["accessors"].size() - 1;
  };
  Json& attributes = model.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["TRANSLATION"] = accessor(view(Bytes(shifts)), 5126, "VEC3");
  attributes["ROTATION"] = accessor(view(Bytes(turns)), 5122, "VEC4");
  model.json["accessors"].back()["normalized"] = true;
  attributes["SCALE"] = accessor(view(Bytes(scales)), 5126, "VEC3");
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  ASSERT_EQ(loaded.scene().objects.size(), 1U);
  const haptics::InputObject& object = loaded.scene().objects[0];
  EXPECT_EQ(object.triangles.size(), 12U);
  EXPECT_NEAR(SignedVolume6(object), (1 + 1 + 8) * 1e-6, 1e-11) << "the mirrored one is turned right side out";
  // Corner (10, 45, 0) mm of the file: itself; turned to (-10, 45, 0) and moved by 20; mirrored and doubled, moved
  // back.
  const double expected[3][3] = {{0.01, 0, 0.045}, {0.01, 0, 0.045}, {-0.02, 0.03, 0.09}};
  for (std::size_t i = 0; i < 3; ++i) {
    bool found = false;
    for (std::size_t v = 4 * i; v < 4 * i + 4; ++v) {
      const base::Vec3& p = object.vertices_base_m[v];
      found = found || std::hypot(p.x - expected[i][0], p.y - expected[i][1], p.z - expected[i][2]) < 1e-6;
    }
    EXPECT_TRUE(found) << i;
  }
  model.json["accessors"][2]["count"] = 2;
  Loaded uneven = LoadBytes(model.Bytes());
  ASSERT_FALSE(uneven.result.ok());
  EXPECT_NE(uneven.result.error().find("/nodes/0/extensions/EXT_mesh_gpu_instancing"), std::string::npos);
}

TEST(SceneLoad, FitScalesAnySizeAboveTheHull) {
  for (const double size : {1e-6, 1.0, 3e4}) {
    Model model = Tetra();
    model.json["nodes"][0]["scale"] = {size, size, size};
    model.json["nodes"][0]["translation"] = {5 * size, -3 * size, 100 * size};
    LoadOptions options = kTouchAll;
    options.fit = true;
    Loaded loaded = LoadBytes(model.Bytes(), options);
    ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
    base::Vec3 lower{1, 1, 1}, upper{-1, -1, -1};
    for (const base::Vec3& p : loaded.scene().objects[0].vertices_base_m) {
      lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
      upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
    }
    EXPECT_NEAR(upper.z, 0.0675, 1e-6);
    EXPECT_NEAR(upper.z - lower.z, 0.04, 1e-6);  // as high as wide: the height is what limits
    EXPECT_NEAR(upper.x + lower.x, 0, 1e-6);
    EXPECT_NEAR(upper.y + lower.y, 0, 1e-6);
    EXPECT_NEAR(loaded.report.fit_scale * size, 4, 1e-3);
    EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
  }
}

TEST(SceneLoad, ScaleAndOffsetOptionsApply) {
  LoadOptions options = kTouchAll;
  options.scale = 2;
  options.offset_base_m = {0.5, 0, 0};
  Loaded loaded = LoadBytes(Tetra().Bytes(), options);
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 8e-6, 1e-10);
  EXPECT_NEAR(loaded.scene().objects[0].vertices_base_m[0].x, 0.5, 1e-7);
  // 0.5 m away: nothing to touch there, and that is said.
  EXPECT_NE(loaded.Warnings().find("nothing to touch within"), std::string::npos) << loaded.Warnings();
}

}  // namespace test_scene_load
}  // namespace omni::scene::test
