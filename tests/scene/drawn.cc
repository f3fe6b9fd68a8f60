// Scenes as pictures show them.
#include <gtest/gtest.h>

#include <cmath>

#include "service/scene/drawn_scene.h"
#include "tests/scene/files.h"

namespace omni::scene {
namespace test_scene_drawn {

using test::AddAccessor;
using test::Bytes;
using test::Json;
using test::Model;
using test::Tetra;

base::Result<DrawnScene> Drawn(const Model& model) {
  const test::TempFolder folder;
  return LoadDrawnScene(folder.Write("model.glb", model.Bytes()));
}

// Every triangle is wound against its vertices' normals' side: area . normal > 0.
void ExpectOutward(const DrawnPart& part) {
  for (const auto& t : part.triangles) {
    const base::Vec3 &a = part.positions_base_m[t[0]], &b = part.positions_base_m[t[1]],
                     &c = part.positions_base_m[t[2]];
    const base::Vec3 u{b.x - a.x, b.y - a.y, b.z - a.z}, v{c.x - a.x, c.y - a.y, c.z - a.z};
    const base::Vec3 area{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    const base::Vec3 centre{0.0033, -0.0033, 0.048};  // of the tetrahedron, in the base frame
    EXPECT_GT(Dot(area, a - centre), 0);
    for (const std::uint32_t k : t) {
      EXPECT_GT(Dot(area, part.normals_base[k]), 0);
      EXPECT_NEAR(Norm(part.normals_base[k]), 1, 1e-9);
    }
  }
}

TEST(SceneDrawn, WithoutNormalsTrianglesAreFlatAndGrey) {
  Model model = Tetra();
  model.json["meshes"][0]["primitives"][0].erase("material");
  const auto scene = Drawn(model);
  ASSERT_TRUE(scene.ok()) << scene.error();
  ASSERT_EQ(scene->parts.size(), 1U);
  const DrawnPart& part = scene->parts[0];
  EXPECT_EQ(part.name, "tetra");
  EXPECT_EQ(part.triangles.size(), 4U);
  EXPECT_EQ(part.positions_base_m.size(), 12U) << "each triangle has its own";
  ExpectOutward(part);
  for (const base::Vec3& colour : part.colours) EXPECT_EQ(colour, (base::Vec3{0.5, 0.5, 0.5}));
  EXPECT_TRUE(scene->notes.empty());
}

TEST(SceneDrawn, ColoursOfMaterialAndVerticesMultiply) {
  Model model = Tetra();
  model.json["materials"][0]["pbrMetallicRoughness"] = {{"baseColorFactor", {0.5, 1, 0.25, 1}},
                                                        {"roughnessFactor", 0.1}};
  EXPECT_EQ(Drawn(model)->parts[0].colours[0], (base::Vec3{0.5, 1, 0.25}));
  EXPECT_EQ(Drawn(model)->parts[0].roughness, 0.1);
  const std::size_t shorts =
      AddAccessor(model,
                  Bytes(std::vector<std::uint16_t>{65535, 0, 65535, 65535, 65535, 0, 65535, 65535, 65535, 0, 65535,
                                                   65535, 65535, 0, 65535, 65535}),
                  {{"componentType", 5123}, {"normalized", true}, {"count", 4}, {"type", "VEC4"}});
  model.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = shorts;
  EXPECT_EQ(Drawn(model)->parts[0].colours[0], (base::Vec3{0.5, 0, 0.25}));
  const std::size_t floats = AddAccessor(model, Bytes(std::vector<float>{1, 1, 0, 1, 1, 0, 1, 1, 0, 1, 1, 0}),
                                         {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  model.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = floats;
  EXPECT_EQ(Drawn(model)->parts[0].colours[0], (base::Vec3{0.5, 1, 0}));
  model.json["materials"][0].erase("pbrMetallicRoughness");
  EXPECT_EQ(Drawn(model)->parts[0].colours[0], (base::Vec3{1, 1, 0})) << "white, where the vertices have colours";
}

TEST(SceneDrawn, NormalsFollowMirroredAndStretchedNodes) {
  Model model = Tetra();
  // Outward from the middle; bytes, as quantised files have them.
  const std::size_t normals =
      AddAccessor(model, Bytes(std::vector<std::int8_t>{-73, -73, -73, 0, 127, 0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0}),
                  {{"componentType", 5120}, {"normalized", true}, {"count", 4}, {"type", "VEC3"}});
  model.json["bufferViews"].back()["byteStride"] = 4;
  model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals;
  const auto plain = Drawn(model);
  ASSERT_TRUE(plain.ok()) << plain.error();
  EXPECT_EQ(plain->parts[0].positions_base_m.size(), 4U) << "normals are the file's";
  EXPECT_NEAR(plain->parts[0].normals_base[0].z, -1 / std::sqrt(3.0), 1e-2) << "glTF's y is the base's z";
  model.json["nodes"][0]["scale"] = {-1, 1, 3};
  model.json["nodes"][0]["rotation"] = {0, 0.7071067811865476, 0, 0.7071067811865476};
  const auto turned = Drawn(model);
  ASSERT_TRUE(turned.ok()) << turned.error();
  // X = R S: x -> -x -> +z; z -> 3 z -> +x; the base has y = -z of glTF.
  const DrawnPart& part = turned->parts[0];
  // Vertices are in the order of the triangles: 0, 2, 1, 3.
  EXPECT_NEAR(part.positions_base_m[2].y, -0.01, 1e-9);
  EXPECT_NEAR(part.positions_base_m[2].x, 0, 1e-9);
  EXPECT_NEAR(part.positions_base_m[3].x, 0.03, 1e-8);
  for (std::size_t i = 0; i < part.normals_base.size(); ++i) {
    EXPECT_NEAR(Norm(part.normals_base[i]), 1, 1e-9);
  }
  const base::Vec3 sharp = part.normals_base[0];
  EXPECT_NEAR(sharp.x / sharp.z, 1.0 / 3, 0.02) << "stretched three times along, the normal leans away";
}

TEST(SceneDrawn, WindingStaysOutwardUnderMirroringNodes) {
  Model model = Tetra();
  ExpectOutward(Drawn(model)->parts[0]);
  for (const Json& matrix : {Json{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1}}) {  // swaps x and z
    model.json["nodes"][0]["matrix"] = matrix;
    const auto scene = Drawn(model);
    ASSERT_TRUE(scene.ok()) << scene.error();
    ExpectOutward(scene->parts[0]);
  }
}

TEST(SceneDrawn, ContainsEveryNodeAndInstance) {
  Model model = Tetra();
  const std::size_t places = AddAccessor(model, Bytes(std::vector<float>{0, 0, 0, 0, 0.1F, 0, 0, 0.2F, 0}),
                                         {{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  model.json["nodes"].push_back({{"mesh", 0}, {"name", "three"}});
  model.json["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
  model.json["nodes"].push_back({{"children", {1}}, {"translation", {0, 1, 0}}});
  model.json["scenes"][0]["nodes"] = {0, 2};
  const auto scene = Drawn(model);
  ASSERT_TRUE(scene.ok()) << scene.error();
  ASSERT_EQ(scene->parts.size(), 4U);
  EXPECT_NEAR(scene->parts[3].positions_base_m[0].z - scene->parts[0].positions_base_m[0].z, 1.2, 1e-6);
}

TEST(SceneDrawn, NotesListWhatIsNotDrawn) {
  Model model = Tetra();
  model.json["nodes"][0]["skin"] = 0;
  model.json["skins"] = Json::parse(R"([{"joints": [0]}])");
  model.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  model.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  model.json["scenes"].push_back(Json::object());
  const auto scene = Drawn(model);
  ASSERT_TRUE(scene.ok()) << scene.error();
  std::string notes;
  for (const std::string& note : scene->notes) notes += note + "\n";
  for (const char* part : {"/meshes/0/primitives/0: has no JOINTS_0",
                           "/materials/0/pbrMetallicRoughness/baseColorTexture: ", "/meshes/0/primitives/1: ", "lines",
                           "/scenes: has 2"}) {
    EXPECT_NE(notes.find(part), std::string::npos) << part << " not in\n" << notes;
  }
}

}  // namespace test_scene_drawn
}  // namespace omni::scene
