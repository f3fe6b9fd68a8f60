// EXT_meshopt_compression: what is decoded is what was encoded, and bad data is refused or harmless.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "service/scene/drawn_scene.h"
#include "service/scene/scene_reader.h"
#include "tests/scene/stream_bombs.h"

namespace omni::scene::test {
namespace test_scene_meshopt {

constexpr const char* kPlace = "/bufferViews/0/extensions/EXT_meshopt_compression";

void ExpectTetra(const Model& model, double tolerance = 1e-9) {
  Loaded loaded = LoadBytes(model.Bytes());
  Loaded plain = LoadBytes(Tetra().Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  const haptics::InputObject &object = loaded.scene().objects.at(0), &expected = plain.scene().objects.at(0);
  ASSERT_EQ(object.vertices_base_m.size(), expected.vertices_base_m.size());
  ASSERT_EQ(object.triangles.size(), expected.triangles.size());
  EXPECT_NEAR(SignedVolume6(object), 1e-6, 0.02 * tolerance + 1e-12);
  for (const base::Vec3& v : object.vertices_base_m) {
    double nearest = 1;
    for (const base::Vec3& e : expected.vertices_base_m) nearest = std::min(nearest, Norm(v - e));
    EXPECT_LE(nearest, tolerance);
  }
  EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
}

void ExpectRefused(const Model& model, const std::string& part) {
  const Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_FALSE(loaded.result.ok()) << "loaded, expected: " << part;
  EXPECT_NE(loaded.result.error().find(part), std::string::npos) << loaded.result.error() << "\nexpected: " << part;
}

TEST(SceneMeshopt, EveryModeIsDecoded) {
  for (const bool triangles : {true, false}) {
    for (const std::size_t stride : {2U, 4U}) ASSERT_NO_FATAL_FAILURE(ExpectTetra(MeshoptTetra(triangles, stride)));
  }
}

TEST(SceneMeshopt, TheNameOfKhronosIsReadToo) {
  Model model = MeshoptTetra();
  for (Json& view : model.json["bufferViews"]) {
    view["extensions"]["KHR_meshopt_compression"] = view["extensions"][kMeshopt];
    view["extensions"].erase(kMeshopt);
  }
  model.json["extensionsRequired"] = {"KHR_meshopt_compression"};
  ExpectTetra(model);
}

// A fallback needs no decoder, and the compressed bytes may be anything then.
TEST(SceneMeshopt, AFallbackWithDataIsRead) {
  Model model = Tetra();
  for (Json& view : model.json["bufferViews"]) {
    view["extensions"][kMeshopt] = {
        {"buffer", 0}, {"byteLength", 16}, {"byteStride", 12}, {"count", 8}, {"mode", "ATTRIBUTES"}};
  }
  ExpectTetra(model);
  const TempFolder folder;
  Model beside = MeshoptTetra();
  beside.json["buffers"][1]["uri"] = "fallback.bin";
  beside.json["buffers"][1]["byteLength"] = 72;
  const std::string path = folder.Write("model.glb", beside.Bytes());
  EXPECT_TRUE(Load(path).result.ok()) << "without the file: decoded";
  std::vector<float> other = TetraPositions();
  other[7] = 0.065F;
  folder.Write("fallback.bin", Bytes(other) + Bytes(TetraIndices()));
  Loaded loaded = Load(path);
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 2e-6, 1e-12) << "with it: read";
}

TEST(SceneMeshopt, SharedViewsAreDecodedOnce) {
  Model model = MeshoptTetra();
  std::vector<float> two = TetraPositions();
  for (const float p : TetraPositions()) two.push_back(2 * p);
  Compress(model, 0, MeshoptVertices(Bytes(two), 12), 8, 12, "ATTRIBUTES");
  model.json["accessors"].push_back(model.json["accessors"][0]);
  model.json["accessors"][2]["byteOffset"] = 48;
  model.json["meshes"].push_back(model.json["meshes"][0]);
  model.json["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = 2;
  model.json["nodes"].push_back({{"mesh", 1}});
  model.json["scenes"][0]["nodes"] = {0, 1};
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects.at(0)), 1e-6, 1e-12);
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects.at(1)), 8e-6, 1e-11);
  EXPECT_LT(loaded.report.bytes_read, model.Bytes().size() + 20) << "each byte once";
}

TEST(SceneMeshopt, ExponentialFilterGivesFloats) {
  std::string encoded(48, '\0');
  meshopt_encodeFilterExp(encoded.data(), 4, 12, 20, TetraPositions().data());
  Model model = MeshoptTetra();
  Compress(model, 0, MeshoptVertices(encoded, 12), 4, 12, "ATTRIBUTES", "EXPONENTIAL");
  ExpectTetra(model, 1e-6);
}

TEST(SceneMeshopt, QuaternionFilterTurnsInstances) {
  const float half = std::sqrt(0.5F);
  const std::vector<float> turns{0, 0, 0, 1, 0, half, 0, half, half, 0, 0, half};
  std::string encoded(24, '\0');
  meshopt_encodeFilterQuat(encoded.data(), 3, 8, 16, turns.data());
  Model model = MeshoptTetra(), plain = Tetra();
  const auto give = [](Model& to, std::size_t accessor) {
    to.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] = accessor;
  };
  give(plain, AddAccessor(plain, Bytes(turns), {{"componentType", 5126}, {"count", 3}, {"type", "VEC4"}}));
  const std::size_t accessor =
      AddAccessor(model, "", {{"componentType", 5122}, {"normalized", true}, {"count", 3}, {"type", "VEC4"}});
  Compress(model, model.json["bufferViews"].size() - 1, MeshoptVertices(encoded, 8), 3, 8, "ATTRIBUTES", "QUATERNION");
  give(model, accessor);
  Loaded a = LoadBytes(model.Bytes()), b = LoadBytes(plain.Bytes());
  ASSERT_TRUE(a.result.ok()) << a.result.error();
  ASSERT_TRUE(b.result.ok()) << b.result.error();
  const auto &decoded = a.scene().objects.at(0).vertices_base_m, &expected = b.scene().objects.at(0).vertices_base_m;
  ASSERT_EQ(decoded.size(), expected.size());
  for (std::size_t i = 0; i < decoded.size(); ++i) EXPECT_LT(Norm(decoded[i] - expected[i]), 2e-5) << i;
}

TEST(SceneMeshopt, OctahedralFilterGivesNormals) {
  const std::vector<float> normals{0, 1, 0, 0, 0.6F, 0, 0.8F, 0, 0, 0, -1, 0, -0.48F, 0.6F, 0.64F, 0};
  const TempFolder folder;
  for (const std::size_t stride : {4U, 8U}) {
    std::string encoded(4 * stride, '\0');
    meshopt_encodeFilterOct(encoded.data(), 4, stride, stride == 4 ? 8 : 16, normals.data());
    Model model = MeshoptTetra();
    const std::size_t accessor = AddAccessor(
        model, "",
        {{"componentType", stride == 4 ? 5120 : 5122}, {"normalized", true}, {"count", 4}, {"type", "VEC3"}});
    const std::size_t view = model.json["bufferViews"].size() - 1;
    Compress(model, view, MeshoptVertices(encoded, stride), 4, stride, "ATTRIBUTES", "OCTAHEDRAL");
    model.json["bufferViews"][view]["byteStride"] = stride;
    model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = accessor;
    const auto drawn = LoadDrawnScene(folder.Write("model.glb", model.Bytes()));
    ASSERT_TRUE(drawn.ok()) << drawn.error();
    ASSERT_EQ(drawn->parts.at(0).normals_base.size(), 4U);
    const std::uint16_t first_use[] = {0, 2, 1, 3};
    for (std::size_t i = 0; i < 4; ++i) {
      const float* n = &normals[4 * std::size_t{first_use[i]}];
      const base::Vec3 expected{static_cast<double>(n[0]), -static_cast<double>(n[2]), static_cast<double>(n[1])};
      EXPECT_LT(Norm(drawn->parts[0].normals_base[i] - expected), stride == 4 ? 0.02 : 2e-4) << i;
    }
  }
}

TEST(SceneMeshopt, WhatTheExtensionDoesNotAllowIsRefusedByPlace) {
  const auto refused = [](const char* key, const Json& value, const std::string& part) {
    Model model = MeshoptTetra();
    model.json["bufferViews"][0]["extensions"][kMeshopt][key] = value;
    SCOPED_TRACE(std::string(key) + " " + value.dump());
    ExpectRefused(model, std::string(kPlace) + part);
  };
  refused("buffer", 9, "/buffer");
  refused("byteOffset", -1, "/byteOffset");
  refused("byteLength", "x", "/byteLength");
  refused("byteStride", 0, "/byteStride");
  refused("byteStride", 6, "/byteStride");
  refused("byteStride", 260, "/byteStride");
  refused("count", -4, "/count");
  refused("count", 1ull << 40, "/count");
  refused("mode", "POINTS", "/mode: is \"POINTS\", and what can be read is ATTRIBUTES, TRIANGLES, INDICES");
  refused("filter", "COLOR", "/filter: is \"COLOR\"");
  refused("filter", "OCTAHEDRAL", "/byteStride");
  refused("filter", "QUATERNION", "/byteStride");
  refused("mode", "INDICES", "/byteStride");
  refused("count", 300, ": its data cannot be decoded");
  refused("byteStride", 16, ": its data cannot be decoded");
  Model model = MeshoptTetra();
  model.json["bufferViews"][1]["extensions"][kMeshopt]["count"] = 11;
  ExpectRefused(model, "/bufferViews/1/extensions/EXT_meshopt_compression/count: is 11, must be a multiple of 3");
  model = MeshoptTetra();
  model.json["accessors"][0]["count"] = 5;
  ExpectRefused(model, "/accessors/0: needs 60 bytes at 0 of /bufferViews/0, which has 48");
  model = MeshoptTetra();
  model.json["bufferViews"][0]["extensions"][kMeshopt]["byteLength"] = 100'000;
  ExpectRefused(model, "/buffers/0: has");
}

// A file of a few bytes cannot take a gigabyte: refused before memory is allocated.
TEST(SceneMeshopt, ExpansionIsLimited) {
  Model model = MeshoptTetra();
  Json& view = model.json["bufferViews"][0]["extensions"][kMeshopt];
  view["count"] = 4'000'000;
  view["byteStride"] = 256;
  ExpectRefused(model, std::string(kPlace) + ": with those before, is decoded to more than");
}

// Each view may have few bytes decoded, but all together cannot be read more often than any file has reason to.
TEST(SceneMeshopt, ViewsThatShareBytesAreLimited) {
  const Loaded loaded = LoadBytes(streams::EmptyViews(100'000));
  ASSERT_FALSE(loaded.result.ok());
  EXPECT_NE(loaded.result.error().find("/bufferViews: the touched meshes have more than"), std::string::npos)
      << loaded.result.error();
  EXPECT_LT(loaded.report.bytes_read, 1'000'000U);
}

// Every truncation, and bytes that are anything.
TEST(SceneMeshopt, DamagedStreamsAreRefusedOrLoadSoundly) {
  std::mt19937 random(3);
  const auto check = [](const Model& model) {
    Loaded loaded = LoadBytes(model.Bytes());
    if (!loaded.result.ok()) return false;
    for (const haptics::InputObject& object : loaded.scene().objects) {
      for (const auto& triangle : object.triangles) {
        for (const std::uint32_t v : triangle) EXPECT_LT(v, object.vertices_base_m.size());
      }
      for (const base::Vec3& p : object.vertices_base_m) EXPECT_TRUE(Norm(p) <= 1e13);
    }
    return true;
  };
  std::size_t refused = 0, all = 0;
  for (const char* filter : {"NONE", "EXPONENTIAL"}) {
    for (const std::size_t view : {0U, 1U}) {
      Model whole = MeshoptTetra(filter[0] == 'N');
      if (view == 0) whole.json["bufferViews"][0]["extensions"][kMeshopt]["filter"] = filter;
      const Json& compressed = whole.json["bufferViews"][view]["extensions"][kMeshopt];
      const auto length = compressed["byteLength"].get<std::size_t>(), at = compressed["byteOffset"].get<std::size_t>();
      for (std::size_t cut = 0; cut < length; ++cut) {
        Model model = whole;
        model.json["bufferViews"][view]["extensions"][kMeshopt]["byteLength"] = cut;
        EXPECT_FALSE(check(model)) << cut << " of " << length;
      }
      for (int run = 0; run < 300; ++run) {
        Model model = whole;
        for (int k = 0; k <= run % 3; ++k) model.bin[at + random() % length] = static_cast<char>(random() & 0xFF);
        refused += check(model) ? 0 : 1;
        ++all;
      }
    }
  }
  EXPECT_GT(refused, all / 10);
  EXPECT_LT(refused, all);
}

TEST(SceneMeshopt, IsCountedBeforeItIsDecoded) {
  const TempFolder folder;
  const Model model = MeshoptTetra();
  LoadReport report;
  const SceneCounts counts = SceneReader(folder.Write("a.glb", model.Bytes()), kTouchAll, report).Count();
  EXPECT_GE(counts.mesh_bytes, 2 * (48U + 24U));
}

}  // namespace test_scene_meshopt
}  // namespace omni::scene::test
