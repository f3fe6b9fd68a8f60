// KHR_draco_mesh_compression: what is decoded is what was encoded, and bad data is refused or harmless.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "service/scene/scene_reader.h"
#include "tests/scene/stream_bombs.h"

namespace omni::scene::test {
namespace test_scene_draco {

constexpr const char* kPlace = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";

using draco::GeometryAttribute;

void ExpectSame(const std::vector<base::Vec3>& vertices, const std::vector<base::Vec3>& expected, double tolerance) {
  ASSERT_EQ(vertices.size(), expected.size());
  for (const base::Vec3& v : vertices) {
    double nearest = 1;
    for (const base::Vec3& e : expected) nearest = std::min(nearest, Norm(v - e));
    EXPECT_LE(nearest, tolerance);
  }
}

void ExpectRefused(const Model& model, const std::string& part) {
  const Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_FALSE(loaded.result.ok()) << "loaded, expected: " << part;
  EXPECT_NE(loaded.result.error().find(part), std::string::npos) << loaded.result.error() << "\nexpected: " << part;
}

TEST(SceneDraco, BothMethodsAreDecoded) {
  Loaded plain = LoadBytes(Tetra().Bytes());
  for (const bool edgebreaker : {false, true}) {
    for (const int bits : {0, 14}) {
      Model model = DracoTetra(edgebreaker, bits);
      for (const bool required : {true, false}) {
        if (!required) model.json.erase("extensionsRequired");
        Loaded loaded = LoadBytes(model.Bytes());
        ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
        const double step_m = bits == 0 ? 1e-12 : 0.01 / (1 << bits);
        ExpectSame(loaded.scene().objects.at(0).vertices_base_m, plain.scene().objects.at(0).vertices_base_m,
                   2 * step_m);
        EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 1e-6, 1e-3 * step_m + 1e-12);
      }
    }
  }
}

// Other attributes are found by their numbers, whatever their order and type: joints and weights.
TEST(SceneDraco, AttributesAreFoundByNumber) {
  for (const bool edgebreaker : {false, true}) {
    for (const draco::DataType joints : {draco::DT_UINT8, draco::DT_UINT16}) {
      Model model = Tetra();
      model.bin.clear();
      model.json["nodes"] = Json::parse(R"([{"mesh": 0, "skin": 0, "translation": [1, 0, 0]},
        {"translation": [0, 0.005, 0]}, {"translation": [0, 0.02, 0]}])");
      model.json["scenes"][0]["nodes"] = {0, 1, 2};
      model.json["skins"] = Json::parse(R"([{"joints": [1, 2]}])");
      model.json["accessors"].push_back(
          {{"componentType", joints == draco::DT_UINT8 ? 5121 : 5123}, {"count", 4}, {"type", "VEC4"}});
      model.json["accessors"].push_back({{"componentType", 5126}, {"count", 4}, {"type", "VEC4"}});
      Json& attributes = model.json["meshes"][0]["primitives"][0]["attributes"];
      attributes["JOINTS_0"] = 2;
      attributes["WEIGHTS_0"] = 3;
      const std::vector<std::uint16_t> numbers{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0};
      const std::vector<DracoAttribute> encoded{
          {"WEIGHTS_0", GeometryAttribute::GENERIC, draco::DT_FLOAT32, 4,
           Bytes(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0})},
          TetraDracoPositions(),
          {"JOINTS_0", GeometryAttribute::GENERIC, joints, 4,
           joints == draco::DT_UINT16 ? Bytes(numbers)
                                      : Bytes(std::vector<std::uint8_t>(numbers.begin(), numbers.end()))}};
      UseDraco(model, EncodeDraco(TetraTriangles(), 4, encoded, edgebreaker), encoded);
      Loaded loaded = LoadBytes(model.Bytes());
      ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
      // The third corner by the second joint.
      ExpectSame(loaded.scene().objects.at(0).vertices_base_m,
                 {{0, 0, 0.05}, {0.01, 0, 0.05}, {0, 0, 0.075}, {0, -0.01, 0.05}}, 1e-8);
    }
  }
}

TEST(SceneDraco, PrimitivesMayShareAStream) {
  Model model = DracoTetra(true);
  model.json["meshes"].push_back(model.json["meshes"][0]);
  model.json["nodes"].push_back({{"mesh", 1}});
  model.json["scenes"][0]["nodes"] = {0, 1};
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects.at(1)), 1e-6, 1e-12);
  EXPECT_LT(loaded.report.bytes_read, model.Bytes().size() + 20) << "each byte once";
  model.json["accessors"].push_back(model.json["accessors"][1]);
  model.json["accessors"].back()["count"] = 9;
  model.json["meshes"][1]["primitives"][0]["indices"] = 2;
  ExpectRefused(model, "is used by primitives whose accessors have different counts");
}

TEST(SceneDraco, WhatDoesNotMatchIsRefusedByPlace) {
  const auto refused = [](const char* at, const Json& value, const std::string& part) {
    for (const bool edgebreaker : {false, true}) {
      Model model = DracoTetra(edgebreaker);
      model.json[Json::json_pointer(at)] = value;
      SCOPED_TRACE(std::string(at) + " " + value.dump());
      ExpectRefused(model, part);
    }
  };
  const std::string place = kPlace;
  refused((place + "/bufferView").c_str(), 9, place + "/bufferView");
  refused((place + "/attributes").c_str(), 9, place + "/attributes");
  refused((place + "/attributes/POSITION").c_str(), 7, place + "/attributes/POSITION: is 7, and its data has no such");
  refused((place + "/attributes/POSITION").c_str(), -1, place + "/attributes/POSITION");
  refused("/accessors/0/count", 3,
          place + ": its data has 4 triangles and 4 vertices, its accessors have 4 triangles and 3");
  refused("/accessors/1/count", 9, place + ": its data has 4 triangles");
  refused("/accessors/1/count", 10, "compressed meshes are read as triangles");
  refused("/meshes/0/primitives/0/mode", 5, "compressed meshes are read as triangles");
  refused("/bufferViews/2/byteLength", 6, place + ": its data is no Draco mesh of version 2.2");
  refused("/bufferViews/2/byteLength", 1 << 20, "/buffers/0: has");
  Model model = DracoTetra(true);
  model.json["meshes"][0]["primitives"][0].erase("indices");
  ExpectRefused(model, "/meshes/0/primitives/0/indices: is missing");
  // Positions of two components, or of a type that positions may not have.
  for (const auto& [type, width] : {std::pair(draco::DT_FLOAT32, 2), std::pair(draco::DT_UINT32, 3)}) {
    DracoAttribute odd = TetraDracoPositions();
    odd.data = type;
    odd.width = width;
    Model wrong = Tetra();
    UseDraco(wrong, EncodeDraco(TetraTriangles(), 4, {odd}, false), {odd});
    ExpectRefused(wrong, place + "/attributes/POSITION: is 0, and its data has no such attribute");
  }
}

// Refused before memory is allocated for what a few bytes say they hold.
TEST(SceneDraco, ExpansionIsLimited) {
  Model model = DracoTetra(true);
  model.json["accessors"][0]["count"] = 6'000'000;
  model.json["accessors"][1]["count"] = 12'000'000;
  ExpectRefused(model, std::string(kPlace) + ": with those before, is decoded to more than");
}

// They are decoded with the others, whoever reads them; so are the tables of corners that each has of its own.
TEST(SceneDraco, AttributesThatNothingReadsAreLimited) {
  for (const bool edgebreaker : {false, true}) {
    ExpectRefused(streams::DracoPlate(18'000, 240, edgebreaker),
                  "its attributes, also those that are not read, are decoded to more than");
    EXPECT_TRUE(LoadBytes(streams::DracoPlate(2'000, 8, edgebreaker).Bytes()).result.ok());
  }
}

// A regular mesh is small: 64 times what its file holds is not much then.
TEST(SceneDraco, APlateOfSquaresIsNotTooLarge) {
  constexpr std::size_t kVertices = 100'000;
  const Model model = streams::DracoPlate(kVertices, 3);
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_LT(64 * model.Bytes().size(), (4 * 6 + 12 + 3 * 16) * kVertices) << "or it is no test of that";
}

TEST(SceneDraco, DamagedStreamsAreRefusedOrLoadSoundly) {
  std::mt19937 random(5);
  std::size_t refused = 0, all = 0;
  const auto check = [&](const Model& model) {
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
  for (const bool edgebreaker : {false, true}) {
    for (const int bits : {0, 11}) {
      const Model whole = DracoTetra(edgebreaker, bits);
      const Json& view = whole.json["bufferViews"].back();
      const auto length = view["byteLength"].get<std::size_t>(), at = view["byteOffset"].get<std::size_t>();
      for (std::size_t cut = 0; cut < length; ++cut) {
        Model model = whole;
        model.json["bufferViews"].back()["byteLength"] = cut;
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

}  // namespace test_scene_draco
}  // namespace omni::scene::test
