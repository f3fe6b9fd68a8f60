// Meshes in the shape that they have before anything moves: skins in the pose of their joints, morph targets by their
// default weights.
#include <gtest/gtest.h>
#include <array>

#include <cmath>
#include <limits>
#include <random>

#include "service/scene/build_estimate.h"
#include "service/scene/drawn_scene.h"
#include "service/scene/scene_reader.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_shapes {

void ExpectRefused(const Loaded& loaded, const std::string& part) {
  ASSERT_FALSE(loaded.result.ok()) << "loaded, expected: " << part;
  EXPECT_NE(loaded.result.error().find(part), std::string::npos) << loaded.result.error() << "\nexpected: " << part;
}

// Corner k of the tetrahedron in the file's frame.
base::Vec3 Corner(std::size_t k) {
  const std::vector<float> p = TetraPositions();
  return {static_cast<double>(p[3 * k]), static_cast<double>(p[3 * k + 1]), static_cast<double>(p[3 * k + 2])};
}

base::Vec3 InBase(const base::Vec3& p) { return {p.x, -p.z, p.y}; }

// Each corner of the tetrahedron, moved by `move`, is a vertex of the object.
template <class Move>
void ExpectMoved(Loaded& loaded, Move move) {
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  ASSERT_EQ(loaded.scene().objects.size(), 1U);
  const std::vector<base::Vec3>& vertices = loaded.scene().objects[0].vertices_base_m;
  ASSERT_EQ(vertices.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    const base::Vec3 expected = InBase(move(Corner(k)));
    double nearest = 1e9;
    for (const base::Vec3& v : vertices) nearest = std::min(nearest, Norm(v - expected));
    EXPECT_LT(nearest, 1e-8) << "corner " << k;
  }
}

// The tetrahedron, held by a joint (node 1) with all its weight; the node itself is a metre away.
Model Skinned() {
  Model model = Tetra();
  model.json["nodes"] = Json::parse(R"([{"name": "tetra", "mesh": 0, "skin": 0, "translation": [1, 0, 0]},
    {"name": "joint", "translation": [0, 0.005, 0]}])");
  model.json["scenes"][0]["nodes"] = {0, 1};
  model.json["skins"] = Json::parse(R"([{"joints": [1]}])");
  Json& attributes = model.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] =
      AddAccessor(model, std::string(16, '\0'), {{"componentType", 5121}, {"count", 4}, {"type", "VEC4"}});
  attributes["WEIGHTS_0"] =
      AddAccessor(model, Bytes(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}),
                  {{"componentType", 5126}, {"count", 4}, {"type", "VEC4"}});
  return model;
}

// Another accessor for an attribute of the only primitive.
template <class T>
void Replace(Model& model, const char* name, const std::vector<T>& values, int component, bool normalized = false) {
  Json accessor = {{"componentType", component}, {"count", values.size() / 4}, {"type", "VEC4"}};
  if (normalized) accessor["normalized"] = true;
  model.json["meshes"][0]["primitives"][0]["attributes"][name] = AddAccessor(model, Bytes(values), accessor);
}

TEST(SceneSkins, JointsPlaceTheMeshAndItsNodeDoesNot) {
  Loaded loaded = LoadBytes(Skinned().Bytes());
  ExpectMoved(loaded, [](base::Vec3 p) { return base::Vec3{p.x, p.y + 0.005, p.z}; });
  EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
  const ExplainRow* skins = nullptr;
  for (const ExplainRow& row : loaded.report.rows) {
    if (row.pointer == "/skins") skins = &row;
  }
  ASSERT_NE(skins, nullptr);
  EXPECT_TRUE(skins->loaded);
}

TEST(SceneSkins, BindPoseOfTheFileIsTheMeshItself) {
  Model model = Skinned();  // inverse bind matrix: the joint's inverse
  const std::vector<float> inverse{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -0.005F, 0, 1};
  model.json["skins"][0]["inverseBindMatrices"] =
      AddAccessor(model, Bytes(inverse), {{"componentType", 5126}, {"count", 1}, {"type", "MAT4"}});
  Loaded loaded = LoadBytes(model.Bytes());
  ExpectMoved(loaded, [](base::Vec3 p) { return p; });
}

// sum w_j (X_j B_j) p, with weights whose sum is not 1, in two sets and in each stored type.
TEST(SceneSkins, WeightsBlendJointsOfTheHierarchy) {
  std::mt19937 random(7);
  const auto in = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  for (int run = 0; run < 60; ++run) {
    Model model = Skinned();
    const bool two_sets = run % 2 == 1;
    const int type = run % 3 == 0 ? 5126 : run % 3 == 1 ? 5121 : 5123;
    const std::size_t joints = two_sets ? 7 : 3;
    model.json["nodes"].push_back({{"translation", {0.01, 0, 0}}, {"children", Json::array()}});
    model.json["scenes"][0]["nodes"].push_back(2);
    std::vector<base::Vec3> shift(joints);
    std::vector<double> scale(joints);
    std::vector<float> inverse;
    model.json["skins"][0]["joints"] = Json::array();
    for (std::size_t j = 0; j < joints; ++j) {
      const base::Vec3 t{in(-0.01, 0.01), in(-0.01, 0.01), in(-0.01, 0.01)};
      scale[j] = in(0.5, 1.5);
      model.json["skins"][0]["joints"].push_back(model.json["nodes"].size());
      model.json["nodes"][2]["children"].push_back(model.json["nodes"].size());
      model.json["nodes"].push_back({{"translation", {t.x, t.y, t.z}}, {"scale", {scale[j], scale[j], scale[j]}}});
      const auto back = static_cast<float>(in(-0.01, 0.01));
      inverse.insert(inverse.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, back, 1});
      shift[j] = {t.x + 0.01, t.y, t.z + scale[j] * static_cast<double>(back)};
    }
    model.json["skins"][0]["inverseBindMatrices"] =
        AddAccessor(model, Bytes(inverse), {{"componentType", 5126}, {"count", joints}, {"type", "MAT4"}});
    std::vector<std::vector<double>> weights(4, std::vector<double>(joints, 0));
    for (std::size_t set = 0; set < (two_sets ? 2U : 1U); ++set) {
      std::vector<std::uint8_t> numbers;
      std::vector<float> floats;
      std::vector<std::uint8_t> bytes;
      std::vector<std::uint16_t> shorts;
      for (std::size_t vertex = 0; vertex < 4; ++vertex) {
        for (std::size_t c = 0; c < 4; ++c) {
          const std::size_t j = std::min(joints - 1, 4 * set + c);
          const bool last = 4 * set + c >= joints;  // its number may be anything
          const double weight = last ? 0 : std::round(in(0, 255));
          numbers.push_back(static_cast<std::uint8_t>(last ? 200 : j));
          floats.push_back(static_cast<float>(weight / 255));
          bytes.push_back(static_cast<std::uint8_t>(weight));
          shorts.push_back(static_cast<std::uint16_t>(257 * weight));
          weights[vertex][j] += weight;
        }
      }
      const std::string at = "_" + std::to_string(set);
      Replace(model, ("JOINTS" + at).c_str(), numbers, 5121);
      if (type == 5126) Replace(model, ("WEIGHTS" + at).c_str(), floats, type);
      if (type == 5121) Replace(model, ("WEIGHTS" + at).c_str(), bytes, type, true);
      if (type == 5123) Replace(model, ("WEIGHTS" + at).c_str(), shorts, type, true);
    }
    Loaded loaded = LoadBytes(model.Bytes());
    std::size_t vertex = 0;
    ASSERT_NO_FATAL_FAILURE(ExpectMoved(loaded, [&](base::Vec3 p) {
      base::Vec3 sum;
      double all = 0;
      for (std::size_t j = 0; j < joints; ++j) {
        sum += weights[vertex][j] * (scale[j] * p + shift[j]);
        all += weights[vertex][j];
      }
      ++vertex;
      return (1 / all) * sum;
    })) << run;
  }
}

TEST(SceneSkins, MirroringJointsKeepTheSolidRightSideOut) {
  Model model = Skinned();
  model.json["nodes"][1]["scale"] = {-1, 1, 1};
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 1e-6, 1e-12);
}

// What exporters leave behind for vertices that belong to no group.
TEST(SceneSkins, AVertexWithoutWeightsIsHeldByItsFirstJoint) {
  Model model = Skinned();
  Replace(model, "WEIGHTS_0", std::vector<float>(16, 0), 5126);
  Loaded loaded = LoadBytes(model.Bytes());
  ExpectMoved(loaded, [](base::Vec3 p) { return base::Vec3{p.x, p.y + 0.005, p.z}; });
}

TEST(SceneSkins, APrimitiveWithoutJointsIsPlacedByItsNode) {
  Model model = Skinned();
  Json& attributes = model.json["meshes"][0]["primitives"][0]["attributes"];
  attributes.erase("JOINTS_0");
  attributes.erase("WEIGHTS_0");
  Loaded loaded = LoadBytes(model.Bytes());
  ExpectMoved(loaded, [](base::Vec3 p) { return base::Vec3{p.x + 1, p.y, p.z}; });
  EXPECT_NE(loaded.Warnings().find("/meshes/0/primitives/0: has no JOINTS_0"), std::string::npos) << loaded.Warnings();
}

TEST(SceneSkins, TwoSkinsOfOneMeshAreTwoShapes) {
  Model model = Skinned();
  model.json["nodes"].push_back({{"mesh", 0}, {"skin", 1}});
  model.json["nodes"].push_back({{"translation", {0, 0.02, 0}}});
  model.json["nodes"].push_back({{"mesh", 0}});
  model.json["scenes"][0]["nodes"] = {0, 1, 2, 3, 4};
  model.json["skins"].push_back({{"joints", {3}}});
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  ASSERT_EQ(loaded.scene().objects.size(), 3U);
  const auto lowest = [&](std::size_t i) {
    double z = 1;
    for (const base::Vec3& v : loaded.scene().objects[i].vertices_base_m) z = std::min(z, v.z);
    return z;
  };
  EXPECT_NEAR(lowest(0), 0.05, 1e-8);
  EXPECT_NEAR(lowest(1), 0.065, 1e-8);
  EXPECT_NEAR(lowest(2), 0.045, 1e-8);
}

TEST(SceneSkins, BadSkinsAreRefusedByPlace) {
  const auto refused = [](const char* at, const Json& value, const std::string& part) {
    Model model = Skinned();
    model.json[Json::json_pointer(at)] = value;
    SCOPED_TRACE(at);
    ExpectRefused(LoadBytes(model.Bytes()), part);
  };
  const std::string attributes = "/meshes/0/primitives/0/attributes/";
  refused("/nodes/0/skin", 1, "/nodes/0/skin");
  refused("/skins/0/joints", Json::array(), "/skins/0/joints: is missing");
  refused("/skins/0/joints", {7}, "/skins/0/joints/0");
  refused("/skins/0/joints", 7, "/skins/0/joints");
  refused("/skins/0/inverseBindMatrices", 0, "/accessors/0/type: must be MAT4");
  refused("/scenes/0/nodes", {0}, "/skins/0/joints/0: is node 1, which is not in the scene");
  refused((attributes + "JOINTS_0").c_str(), 1, "JOINTS_0");
  refused((attributes + "WEIGHTS_1").c_str(), 3, attributes + "JOINTS_1: is missing");
  Model model = Skinned();
  Replace(model, "JOINTS_0", std::vector<std::uint16_t>{0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, 5123);
  ExpectRefused(LoadBytes(model.Bytes()), attributes + "JOINTS_0: vertex 2 names joint 1 of 1");
  for (const float bad : {-0.5F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    model = Skinned();
    std::vector<float> weights(16, 0.25F);
    weights[6] = bad;
    Replace(model, "WEIGHTS_0", weights, 5126);
    Replace(model, "JOINTS_0", std::vector<std::uint8_t>(16, 0), 5121);
    ExpectRefused(LoadBytes(model.Bytes()), attributes + "WEIGHTS_0: vertex 1");
    model = Skinned();
    std::vector<float> inverse{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    inverse[13] = std::numeric_limits<float>::quiet_NaN();
    model.json["skins"][0]["inverseBindMatrices"] =
        AddAccessor(model, Bytes(inverse), {{"componentType", 5126}, {"count", 1}, {"type", "MAT4"}});
    ExpectRefused(LoadBytes(model.Bytes()), "/skins/0/inverseBindMatrices: matrix 0");
  }
  model = Skinned();
  const Json joints = model.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"],
             weights = model.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"];
  for (int set = 1; set < 9; ++set) {
    model.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_" + std::to_string(set)] = joints;
    model.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_" + std::to_string(set)] = weights;
  }
  ExpectRefused(LoadBytes(model.Bytes()), "JOINTS_8: is beyond the limit of 8 sets");
  model = Skinned();
  for (int skin = 1; skin < 3; ++skin) {
    model.json["skins"].push_back({{"joints", std::vector<int>(60'000, 1)}});
    model.json["nodes"].push_back({{"mesh", 0}, {"skin", skin}});
    model.json["scenes"][0]["nodes"].push_back(1 + skin);
  }
  ExpectRefused(LoadBytes(model.Bytes()), "/skins/2/joints: with those of other skins, has more than 100000 joints");
}

// With a target that moves the third corner 20 mm up.
Model Morphed() {
  Model model = Tetra();
  const std::vector<float> moved{0, 0, 0, 0, 0, 0, 0, 0.02F, 0, 0, 0, 0};
  const std::size_t accessor =
      AddAccessor(model, Bytes(moved), {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  model.json["meshes"][0]["primitives"][0]["targets"] = Json::array({{{"POSITION", accessor}}});
  model.json["meshes"][0]["weights"] = {1};
  return model;
}

auto Raised(double by_m) {
  return [by_m](base::Vec3 p) { return base::Vec3{p.x, p.y + (p.y > 0.05 ? by_m : 0), p.z}; };
}

TEST(SceneMorphs, DefaultWeightsApply) {
  Loaded loaded = LoadBytes(Morphed().Bytes());
  ExpectMoved(loaded, Raised(0.02));
}

TEST(SceneMorphs, ANodesWeightsComeFirst) {
  Model model = Morphed();
  model.json["nodes"][0]["weights"] = {-0.25};
  Loaded loaded = LoadBytes(model.Bytes());
  ExpectMoved(loaded, Raised(-0.005));
  model.json["nodes"][0]["weights"] = {0};
  Loaded still = LoadBytes(model.Bytes());
  ExpectMoved(still, Raised(0));
  model.json["meshes"][0].erase("weights");
  model.json["nodes"][0]["weights"] = {0.5};
  model.json["nodes"].push_back({{"mesh", 0}});
  model.json["scenes"][0]["nodes"] = {0, 1};
  Loaded two = LoadBytes(model.Bytes());
  ASSERT_TRUE(two.result.ok()) << two.result.error();
  ASSERT_EQ(two.scene().objects.size(), 2U);
  EXPECT_NEAR(SignedVolume6(two.scene().objects[0]), 2e-6, 1e-12);
  EXPECT_NEAR(SignedVolume6(two.scene().objects[1]), 1e-6, 1e-12);
}

// Blender writes targets as sparse accessors without data of their own.
TEST(SceneMorphs, SparseAndQuantisedTargetsAddUp) {
  Model model = Morphed();
  Json& accessor = model.json["accessors"].back();
  accessor.erase("bufferView");
  const std::size_t index = AddAccessor(model, std::string("\2\0\0\0", 4), {{"count", 0}}),
                    value = AddAccessor(model, Bytes(std::vector<float>{0, 0.02F, 0}), {{"count", 0}});
  model.json["accessors"][2]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", model.json["accessors"][index]["bufferView"]}, {"componentType", 5121}}},
      {"values", {{"bufferView", model.json["accessors"][value]["bufferView"]}}}};
  std::string rows;  // int16 in rows of eight bytes
  for (const std::int16_t y : std::array<std::int16_t, 4>{0, 0, 32767, 0})
    rows += Bytes(std::vector<std::int16_t>{0, y, 0, 99});
  const std::size_t quantised =
      AddAccessor(model, rows, {{"componentType", 5122}, {"normalized", true}, {"count", 4}, {"type", "VEC3"}});
  model.json["bufferViews"].back()["byteStride"] = 8;
  model.json["meshes"][0]["primitives"][0]["targets"].push_back({{"POSITION", quantised}});
  model.json["meshes"][0]["primitives"][0]["targets"].push_back({{"NORMAL", 0}});
  model.json["meshes"][0]["weights"] = {0.5, 0.001, 3};
  Loaded loaded = LoadBytes(model.Bytes());
  ExpectMoved(loaded, Raised(0.011));
}

TEST(SceneMorphs, MorphsComeBeforeTheSkin) {
  Model model = Skinned();
  const std::vector<float> moved{0, 0, 0, 0, 0, 0, 0, 0.02F, 0, 0, 0, 0};
  model.json["meshes"][0]["primitives"][0]["targets"] = Json::array(
      {{{"POSITION", AddAccessor(model, Bytes(moved), {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}})}}});
  model.json["nodes"][0]["weights"] = {1};
  model.json["nodes"][1]["scale"] = {1, 0.5, 1};
  Loaded loaded = LoadBytes(model.Bytes());
  ExpectMoved(loaded, [](base::Vec3 p) { return base::Vec3{p.x, 0.005 + 0.5 * (p.y + (p.y > 0.05 ? 0.02 : 0)), p.z}; });
}

TEST(SceneMorphs, BadMorphsAreRefusedByPlace) {
  const auto refused = [](const char* at, const Json& value, const std::string& part) {
    Model model = Morphed();
    model.json[Json::json_pointer(at)] = value;
    SCOPED_TRACE(at);
    ExpectRefused(LoadBytes(model.Bytes()), part);
  };
  refused("/meshes/0/weights", {0, 1}, "/meshes/0/primitives/0/targets: has 1 elements, but target 1");
  refused("/meshes/0/weights", {"a"}, "/meshes/0/weights/0");
  refused("/nodes/0/weights", {1e9}, "/nodes/0/weights/0");
  refused("/nodes/0/weights", 1, "/nodes/0/weights");
  refused("/nodes/0/weights", std::vector<double>(200, 1), "/nodes/0/weights: has more than 64 weights");
  refused("/meshes/0/primitives/0/targets/0", {{"POSITION", 1}}, "targets/0/POSITION: has 12 elements");
  refused("/meshes/0/primitives/0/targets/0", {{"POSITION", 9}}, "/meshes/0/primitives/0/targets/0/POSITION");
  refused("/accessors/2/count", 3, "/meshes/0/primitives/0/targets/0/POSITION: has 3 elements, must have 4");
  Model model = Morphed();
  const std::vector<float> moved{0, 0, 0, 0, 0, 0, 0, std::numeric_limits<float>::infinity(), 0, 0, 0, 0};
  model.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] =
      AddAccessor(model, Bytes(moved), {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  ExpectRefused(LoadBytes(model.Bytes()), "vertex 2 is not finite");
}

TEST(SceneShapes, PicturesHaveTheSameShape) {
  const TempFolder folder;
  for (const Model& model : {Skinned(), Morphed()}) {
    const std::string path = folder.Write("model.glb", model.Bytes());
    const auto drawn = LoadDrawnScene(path);
    ASSERT_TRUE(drawn.ok()) << drawn.error();
    Loaded loaded = Load(path);
    ASSERT_TRUE(loaded.result.ok());
    for (const base::Vec3& v : loaded.scene().objects[0].vertices_base_m) {
      double nearest = 1e9;
      for (const base::Vec3& p : drawn->parts.at(0).positions_base_m) nearest = std::min(nearest, Norm(v - p));
      EXPECT_LT(nearest, 1e-9);
    }
  }
}

// What is read for shapes is counted before it is read.
TEST(SceneShapes, AreEstimated) {
  const TempFolder folder;
  for (const Model& model : {Skinned(), Morphed()}) {
    LoadReport report, plain_report;
    Model plain = model;
    plain.json["nodes"][0].erase("skin");
    plain.json["meshes"][0].erase("weights");
    const SceneCounts counts = SceneReader(folder.Write("a.glb", model.Bytes()), kTouchAll, report).Count();
    const SceneCounts before = SceneReader(folder.Write("b.glb", plain.Bytes()), kTouchAll, plain_report).Count();
    EXPECT_GE(counts.mesh_bytes, before.mesh_bytes + 48);
  }
}

}  // namespace test_scene_shapes
}  // namespace omni::scene::test
