// The same bodies as each exporter writes them: what is touched is what the plain file has, within the quantisation's
// step.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/scene/exporters.h"
#include "tests/support/mesh_bombs.h"

namespace omni::scene::test {
namespace test_scene_exporters {

using omni::test::Soup;

Model Empty() {
  Model model;
  model.json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
    "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]})");
  return model;
}

void AddNode(Model& model, const Json& node) {
  model.json["scenes"][0]["nodes"].push_back(model.json["nodes"].size());
  model.json["nodes"].push_back(node);
}

std::vector<std::array<float, 3>> FilePositions(const Soup& soup) {
  std::vector<std::array<float, 3>> positions;
  for (const base::Vec3& p : soup.vertices_base_m)
    positions.push_back({static_cast<float>(p.x), static_cast<float>(p.z), static_cast<float>(-p.y)});
  return positions;
}

// A mesh of one primitive, with indices.
void AddMesh(Model& model, const Soup& soup) {
  const auto positions = FilePositions(soup);
  const std::size_t vertices =
      AddAccessor(model, Bytes(positions), {{"componentType", 5126}, {"count", positions.size()}, {"type", "VEC3"}});
  const std::size_t corners =
      AddAccessor(model, Bytes(soup.triangles),
                  {{"componentType", 5125}, {"count", 3 * soup.triangles.size()}, {"type", "SCALAR"}});
  const Json primitive = {{"attributes", {{"POSITION", vertices}}}, {"indices", corners}};
  model.json["meshes"].push_back({{"primitives", Json::array({primitive})}});
}

// Three corners of its own for each triangle, as flat faces have them; no indices.
void AddSoupMesh(Model& model, const Soup& soup) {
  const auto positions = FilePositions(soup);
  std::vector<std::array<float, 3>> corners;
  for (const auto& triangle : soup.triangles)
    for (const std::uint32_t vertex : triangle) corners.push_back(positions[vertex]);
  const std::size_t accessor =
      AddAccessor(model, Bytes(corners), {{"componentType", 5126}, {"count", corners.size()}, {"type", "VEC3"}});
  const Json primitive = {{"attributes", {{"POSITION", accessor}}}};
  model.json["meshes"].push_back({{"primitives", Json::array({primitive})}});
}

Soup Box() {
  Soup soup;
  for (std::uint32_t i = 0; i < 8; ++i)
    omni::test::meshes::Put(soup, {i & 1 ? 0.02 : -0.02, i & 2 ? 0.013 : -0.013, i & 4 ? 0.057 : 0.042});
  soup.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return soup;
}

// Two nodes show it, one of them turned and larger.
Model Blocks() {
  Model model = Empty();
  AddSoupMesh(model, Box());
  AddNode(model, {{"mesh", 0}});
  AddNode(model, {{"mesh", 0},
                  {"translation", {0.005, 0.01, -0.003}},
                  {"rotation", {0.36, 0.48, 0, 0.8}},
                  {"scale", {1.1, 0.9, 1.2}}});
  return model;
}

Model Ball() {
  Model model = Empty();
  AddSoupMesh(model, omni::test::meshes::CleanBall(6000));
  AddNode(model, {{"mesh", 0}, {"translation", {0, 0.001, 0}}});
  return model;
}

// Bent by two joints, more so the higher a vertex is.
Model Skinned() {
  Model model = Empty();
  const Soup ball = omni::test::meshes::CleanBall(2000);
  AddMesh(model, ball);
  std::vector<std::array<float, 4>> weights;
  for (const base::Vec3& p : ball.vertices_base_m) {
    const auto high = static_cast<float>(std::clamp((p.z - 0.03) / 0.04, 0.0, 1.0));
    weights.push_back({1 - high, high, 0, 0});
  }
  Json& attributes = model.json["meshes"][0]["primitives"][0]["attributes"];
  const std::vector<std::array<std::uint8_t, 4>> joints(weights.size(), {0, 1, 0, 0});
  attributes["JOINTS_0"] =
      AddAccessor(model, Bytes(joints), {{"componentType", 5121}, {"count", joints.size()}, {"type", "VEC4"}});
  attributes["WEIGHTS_0"] =
      AddAccessor(model, Bytes(weights), {{"componentType", 5126}, {"count", weights.size()}, {"type", "VEC4"}});
  std::vector<float> inverse{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -0.03F, 0, 1};
  inverse.insert(inverse.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.001F, -0.05F, 0, 1});
  const std::size_t matrices =
      AddAccessor(model, Bytes(inverse), {{"componentType", 5126}, {"count", 2}, {"type", "MAT4"}});
  model.json["skins"] = Json::array({{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}});
  AddNode(model, {{"mesh", 0}, {"skin", 0}, {"translation", {0.3, 0, 0}}});
  AddNode(model, {{"translation", {0, 0.031, 0}}});
  AddNode(model, {{"translation", {0.002, 0.05, 0}}, {"rotation", {0, 0, 0.28, 0.96}}});
  return model;
}

Model Instanced() {
  Model model = Empty();
  AddMesh(model, Box());
  const std::vector<float> places{0, 0, 0, 0.03F, 0.01F, 0, -0.03F, 0, 0.02F};
  const std::vector<float> turns{0, 0, 0, 1, 0.6F, 0, 0, 0.8F, 0, 0.48F, 0.6F, 0.64F};
  const std::vector<float> scales{1, 1, 1, 0.5F, 0.6F, 0.7F, 0.9F, 0.3F, 0.4F};
  const auto add = [&](const std::vector<float>& values, const char* type) {
    return AddAccessor(model, Bytes(values), {{"componentType", 5126}, {"count", 3}, {"type", type}});
  };
  const Json attributes = {
      {"TRANSLATION", add(places, "VEC3")}, {"ROTATION", add(turns, "VEC4")}, {"SCALE", add(scales, "VEC3")}};
  AddNode(model, {{"mesh", 0}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
  return model;
}

// A shipped scene without its tags, so that all of it is touched whatever a style joins.
Model Shipped(const std::string& name) {
  const std::string bytes = ReadAll(OMNI_SOURCE_DIR "/scenes/" + name + ".glb");
  std::uint32_t length = 0;
  std::memcpy(&length, &bytes[12], sizeof length);
  Model model{.json = Json::parse(bytes.substr(20, length)), .bin = bytes.substr(28 + length)};
  for (const char* list : {"nodes", "meshes"}) {
    for (Json& item : model.json[list]) {
      item.erase("extras");
      item.erase("extensions");
    }
  }
  return model;
}

struct Size {
  base::Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  std::size_t triangles = 0;
  double volume6 = 0;        // with its sign
  double volume6_per_m = 0;  // most that it changes by when all vertices move
  double Largest() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

void AddTo(Size& size, const haptics::InputObject& object) {
  for (const base::Vec3& p : object.vertices_base_m) {
    size.low = {std::min(size.low.x, p.x), std::min(size.low.y, p.y), std::min(size.low.z, p.z)};
    size.high = {std::max(size.high.x, p.x), std::max(size.high.y, p.y), std::max(size.high.z, p.z)};
  }
  size.triangles += object.triangles.size();
  size.volume6 += SignedVolume6(object);
  for (const auto& [i, j, k] : object.triangles) {
    const base::Vec3 &a = object.vertices_base_m[i], &b = object.vertices_base_m[j], &c = object.vertices_base_m[k];
    size.volume6_per_m += Norm(Cross(a, b)) + Norm(Cross(b, c)) + Norm(Cross(c, a));
  }
}

// Of each object; joined: of all in one.
std::vector<Size> Sizes(haptics::SceneInput& scene, bool joined) {
  std::vector<Size> sizes(joined ? 1 : scene.objects.size());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) AddTo(sizes[joined ? 0 : i], scene.objects[i]);
  return sizes;
}

// How far a style may move a coordinate of a body.
double StepOf_m(const Style& style, const Size& plain) {
  constexpr double kFloats = 2e-8;
  if (style.bits == 0) return style.join ? kFloats : 1e-12;
  // A sign and a mantissa, of a number up to 1: the library takes a coordinate of 0 for one.
  if (style.exponents) return kFloats + 1.0 / (1 << (style.bits - 1));
  return kFloats + plain.Largest() / ((1 << style.bits) - 2);
}

void ExpectSame(const Size& size, const Size& plain, double step_m) {
  EXPECT_EQ(size.triangles, plain.triangles);
  for (const base::Vec3& d : {size.low - plain.low, size.high - plain.high})
    EXPECT_LE(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}), step_m);
  EXPECT_LE(std::abs(size.volume6 - plain.volume6), step_m * plain.volume6_per_m);
}

TEST(SceneExporters, EachStyleIsTheSameBody) {
  const std::pair<const char*, Model> bodies[] = {{"blocks", Blocks()},
                                                  {"ball", Ball()},
                                                  {"skinned", Skinned()},
                                                  {"instanced", Instanced()},
                                                  {"dragon", Shipped("dragon")},
                                                  {"extrusion", Shipped("extrusion")},
                                                  {"racetrack", Shipped("racetrack")}};
  for (const auto& [name, model] : bodies) {
    SCOPED_TRACE(name);
    Loaded plain = LoadBytes(model.Bytes());
    ASSERT_TRUE(plain.result.ok()) << plain.result.error();
    for (const Style& style : kStyles) {
      SCOPED_TRACE(style.name);
      const TempFolder folder;
      Exporter exporter(model, style);
      const Model exported = exporter.Export();
      if (style.fallback) folder.Write(kFallbackFile, exporter.fallback());
      Loaded loaded = Load(folder.Write("model.glb", exported.Bytes()));
      ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
      EXPECT_EQ(loaded.report.warnings.size(), plain.report.warnings.size()) << loaded.Warnings();
      const std::vector<Size> sizes = Sizes(loaded.scene(), style.join), expected = Sizes(plain.scene(), style.join);
      ASSERT_EQ(sizes.size(), expected.size());
      for (std::size_t i = 0; i < sizes.size(); ++i) ExpectSame(sizes[i], expected[i], StepOf_m(style, expected[i]));
      if (style.packing != Packing::kNone && plain.report.bytes_read > 50'000) {
        EXPECT_LT(2 * exported.Bytes().size(), model.Bytes().size()) << "or nothing was compressed";
      }
    }
  }
}

}  // namespace test_scene_exporters
}  // namespace omni::scene::test
