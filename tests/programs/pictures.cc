// scene_render draws any glTF file, or reports file, JSON pointer and what is missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <stb/stb_image.h>

#include "tests/scene/files.h"
#include "tests/support/process/program.h"

namespace omni::test {
namespace test_programs_pictures {

using scene::test::AddAccessor;
using scene::test::Bytes;
using scene::test::Json;
using scene::test::Model;
using scene::test::Tetra;

Json& Primitive(Model& model) { return model.json["meshes"][0]["primitives"][0]; }

// A red tetrahedron, so that a picture shows whether it is there.
Model Red() {
  Model model = Tetra();
  model.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 0, 0, 1};
  return model;
}

Ran Draw(const std::string& file, const std::string& picture) {
  return RunProgram(
      {BinaryPath("scene_render"), file, picture, "--width", "48", "--height", "48", "--supersampling", "1"});
}

// Share of the picture's pixels that are red.
double RedShare(const std::string& picture) {
  int width = 0, height = 0, channels = 0;
  unsigned char* pixels = stbi_load(picture.c_str(), &width, &height, &channels, 3);
  if (pixels == nullptr) return -1;
  int red = 0;
  for (int i = 0; i < width * height; ++i) red += pixels[3 * i] > pixels[3 * i + 1] + 60 ? 1 : 0;
  stbi_image_free(pixels);
  return static_cast<double>(red) / (width * height);
}

struct Case {
  const char* name;
  std::function<void(Model&)> change;
  std::vector<std::string> said = {};  // none: it is drawn
};

void ExpectOfEach(const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name);
    const TempFolder folder;
    Model model = Red();
    one.change(model);
    const std::string file = folder.Write("model.glb", model.Bytes()), picture = folder.Path("model.png");
    const Ran ran = Draw(file, picture);
    EXPECT_EQ(ran.err.find("exception"), std::string::npos) << ran.err;
    if (one.said.empty()) {
      EXPECT_EQ(ran.status, 0) << ran.err;
      EXPECT_GT(RedShare(picture), 0.05);
      continue;
    }
    EXPECT_EQ(ran.status, 1);
    EXPECT_FALSE(std::filesystem::exists(picture));
    EXPECT_EQ(ran.err.find("scene_render: " + file + ": "), 0U) << ran.err;
    for (const std::string& part : one.said) EXPECT_NE(ran.err.find(part), std::string::npos) << ran.err;
  }
}

TEST(SceneRender, DrawsEveryKindOfTrianglePrimitive) {
  ExpectOfEach({
      {"as it is", [](Model&) {}},
      {"no indices", [](Model& m) { Primitive(m).erase("indices"); }},
      {"a strip", [](Model& m) { Primitive(m)["mode"] = 5; }},
      {"a fan", [](Model& m) { Primitive(m)["mode"] = 6; }},
      {"quantised positions",
       [](Model& m) {
         Primitive(m)["attributes"]["POSITION"] =
             AddAccessor(m, Bytes(std::vector<std::int16_t>{0, 0, 0, 9000, 0, 0, 0, 9000, 0, 0, 0, 9000}),
                         {{"componentType", 5122}, {"normalized", true}, {"count", 4}, {"type", "VEC3"}});
       }},
      {"sparse positions",
       [](Model& m) {
         const std::size_t indices = AddAccessor(m, Bytes(std::vector<std::uint16_t>{2, 0}), Json::object());
         const std::size_t values = AddAccessor(m, Bytes(std::vector<float>{0, 0.065F, 0}), Json::object());
         m.json["accessors"][0]["sparse"] = {
             {"count", 1},
             {"indices", {{"bufferView", m.json["accessors"][indices]["bufferView"]}, {"componentType", 5123}}},
             {"values", {{"bufferView", m.json["accessors"][values]["bufferView"]}}}};
         m.json["accessors"].erase(values);
         m.json["accessors"].erase(indices);
       }},
      {"a hierarchy",
       [](Model& m) { m.json["nodes"] = Json::parse(R"([{"children": [1], "scale": [2, 2, 2]}, {"mesh": 0}])"); }},
      {"no scene at all",
       [](Model& m) {
         m.json.erase("scenes");
         m.json.erase("scene");
       }},
      {"several scenes",
       [](Model& m) { m.json["scenes"] = Json::parse(R"([{"nodes": []}, {"nodes": [0]}])"), m.json["scene"] = 1; }},
      {"a skin",
       [](Model& m) { m.json["nodes"][0]["skin"] = 0, m.json["skins"] = Json::parse(R"([{"joints": [0]}])"); }},
      {"morph targets", [](Model& m) { Primitive(m)["targets"] = Json::parse(R"([{"POSITION": 0}])"); }},
      {"flat, seen from its edge",
       [](Model& m) {
         m.json["nodes"][0]["scale"] = {1, 1, 1e-9};
       }},
      {"a kilometre",
       [](Model& m) {
         m.json["nodes"][0]["scale"] = {1e5, 1e5, 1e5};
       }},
      {"a micrometre",
       [](Model& m) {
         m.json["nodes"][0]["scale"] = {1e-4, 1e-4, 1e-4};
       }},
  });
}

TEST(SceneRender, DrawsMeshWithoutMaterialInGrey) {
  const TempFolder folder;
  Model model = Tetra();
  Primitive(model).erase("material");
  model.json.erase("materials");
  const Ran ran = Draw(folder.Write("model.glb", model.Bytes()), folder.Path("model.png"));
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_EQ(RedShare(folder.Path("model.png")), 0);
}

TEST(SceneRender, ErrorsPointToTheInvalidJsonElement) {
  ExpectOfEach({
      {"points", [](Model& m) { Primitive(m)["mode"] = 0; }, {"/meshes/0/primitives/0 ", "points", "triangles"}},
      {"no position",
       [](Model& m) { Primitive(m)["attributes"].erase("POSITION"); },
       {"/meshes/0/primitives/0 ", "POSITION"}},
      {"an empty scene",
       [](Model& m) { m.json["scenes"][0]["nodes"] = Json::array(); },
       {"/scenes/0: ", "nothing to draw"}},
      {"a scene without nodes",
       [](Model& m) { m.json["scenes"][0].erase("nodes"); },
       {"/scenes/0: ", "nothing to draw"}},
      {"nothing at all",
       [](Model& m) { m.json = Json::parse(R"({"asset": {"version": "2.0"}})"); },
       {"/nodes: ", "nothing to draw"}},
      {"no such mesh", [](Model& m) { m.json["nodes"][0]["mesh"] = 7; }, {"/nodes/0/mesh: "}},
      {"no such material", [](Model& m) { Primitive(m)["material"] = 3; }, {"/meshes/0/primitives/0/material: "}},
      {"a colour of words",
       [](Model& m) { m.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = "red"; },
       {"/materials/0/pbrMetallicRoughness/baseColorFactor: "}},
      {"a rough word",
       [](Model& m) { m.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = "very"; },
       {"/materials/0/pbrMetallicRoughness/roughnessFactor: "}},
      {"normals of bytes without sign",
       [](Model& m) {
         Primitive(m)["attributes"]["NORMAL"] =
             AddAccessor(m, std::string(12, '\1'), {{"componentType", 5121}, {"count", 4}, {"type", "VEC3"}});
       },
       {"/accessors/2/componentType: ", "normals"}},
      {"too few normals",
       [](Model& m) {
         Primitive(m)["attributes"]["NORMAL"] = AddAccessor(m, Bytes(std::vector<float>{0, 1, 0}),
                                                            {{"componentType", 5126}, {"count", 1}, {"type", "VEC3"}});
       },
       {"/meshes/0/primitives/0/attributes/NORMAL: "}},
      {"an index too high",
       [](Model& m) { m.json["accessors"][1]["byteOffset"] = 0, m.bin[60] = '\7'; },
       {"/meshes/0/primitives/0/indices: "}},
      {"an accessor beyond its view", [](Model& m) { m.json["accessors"][0]["count"] = 400; }, {"/accessors/0: "}},
      {"a name of numbers", [](Model& m) { m.json["nodes"][0]["name"] = 5; }, {"/nodes/0/name: "}},
      {"all in one point",
       [](Model& m) {
         m.json["nodes"][0]["scale"] = {0, 0, 0};
       },
       {"one point"}},
      {"out of this world",
       [](Model& m) {
         m.json["nodes"][0]["translation"] = {0, 1e9, 0};
       },
       {"/nodes/0: ", "1e6 m"}},
      {"no such buffer file",
       [](Model& m) { m.json["buffers"][0]["uri"] = "gone.bin"; },
       {"/buffers/0/uri: ", "gone.bin"}},
  });
}

TEST(SceneRender, ReadsExternalAndEmbeddedBuffers) {
  const TempFolder folder;
  Model model = Red();
  folder.Write("model.bin", model.bin);
  model.json["buffers"][0]["uri"] = "model.bin";
  const std::string beside = folder.Write("model.gltf", model.json.dump()), picture = folder.Path("model.png");
  EXPECT_EQ(Draw(beside, picture).status, 0);
  EXPECT_GT(RedShare(picture), 0.05);
  model.bin.resize(72);
  std::string base64;
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i + 2 < model.bin.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | static_cast<unsigned char>(model.bin[i + k]);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += kDigits[group >> shift & 63];
  }
  model.json["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64;
  std::filesystem::remove(picture);
  EXPECT_EQ(Draw(folder.Write("embedded.gltf", model.json.dump()), picture).status, 0);
  EXPECT_GT(RedShare(picture), 0.05);
}

TEST(SceneRender, RejectsFilesThatAreNotScenes) {
  const TempFolder folder;
  const std::string picture = folder.Path("x.png");
  const struct {
    std::string file;
    const char* said;
  } rows[] = {{folder.Path("gone.glb"), "there is no scene"},
              {folder.Path(), "there is no scene"},
              {folder.Write("empty.glb", ""), "is empty"},
              {folder.Write("text.glb", "hello, world"), "neither binary glTF"},
              {folder.Write("cut.glb", Red().Bytes().substr(0, 40)), "truncated"},
              {folder.Write("broken.gltf", "{\"asset\": "), "JSON cannot be parsed"},
              {folder.Write("list.gltf", "[{}]"), "neither binary glTF"},
              {folder.Write("old.gltf", R"({"asset": {"version": "1.0"}})"), "/asset/version"},
              {"/dev/zero", "/dev/zero"},
              {"dargon", "did you mean 'dragon'?"}};
  for (const auto& row : rows) {
    const Ran ran = Draw(row.file, picture);
    EXPECT_EQ(ran.status, 1) << row.file;
    EXPECT_NE(ran.err.find(row.said), std::string::npos) << ran.err;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }
}

TEST(SceneRender, FindsShippedScenesAndWritesOnlyPng) {
  const TempFolder folder;
  EXPECT_EQ(Draw("extrusion", folder.Path("a.png")).status, 0);
  EXPECT_EQ(Draw("extrusion.glb", folder.Path("b.png")).status, 0);
  const Ran jpeg = Draw("extrusion", folder.Path("a.jpg"));
  EXPECT_EQ(jpeg.status, 2);
  EXPECT_NE(jpeg.err.find(".png"), std::string::npos) << jpeg.err;
  const Ran nowhere = Draw("extrusion", folder.Path("no/a.png"));
  EXPECT_EQ(nowhere.status, 1);
  EXPECT_NE(nowhere.err.find("no/a.png: cannot be written"), std::string::npos) << nowhere.err;
}

}  // namespace test_programs_pictures
}  // namespace omni::test
