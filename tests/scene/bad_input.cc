// Bad and hostile files: refused with a message that names the file, the place and the remedy.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <limits>

#include "service/haptics/scene/scene.h"
#include "service/scene/load_scene.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_bad_input {

void ExpectRefused(const Loaded& loaded, const std::string& part) {
  ASSERT_FALSE(loaded.result.ok()) << "loaded, expected: " << part;
  EXPECT_NE(loaded.result.error().find(part), std::string::npos) << loaded.result.error() << "\nexpected: " << part;
}

TEST(SceneBadInput, RejectsMissingEmptyAndNonGltfFiles) {
  const TempFolder folder;
  ExpectRefused(Load(folder.Path("nothing.glb")), "nothing.glb: cannot be opened (No such file");
  ExpectRefused(Load(folder.Path()), "is not a regular file");
  ExpectRefused(Load(folder.Write("empty.glb", "")), "is empty");
  ExpectRefused(Load(folder.Write("text.glb", "solid cube\nfacet")), "neither binary glTF");
  ExpectRefused(Load(folder.Write("short.glb", "glTF\2")), "cut off inside the binary glTF header");
  const std::string fifo = folder.Path("fifo.glb");
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  ExpectRefused(Load(fifo), "is not a regular file");
}

TEST(SceneBadInput, EveryTruncationIsRefused) {
  const std::string whole = Tetra().Bytes();
  const TempFolder folder;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(Load(folder.Write("cut.glb", whole.substr(0, length))).result.ok()) << length;
  }
}

TEST(SceneBadInput, RejectsInconsistentGlbHeaders) {
  std::string bytes = Tetra().Bytes();
  const auto with = [&bytes](std::size_t at, std::uint32_t value) {
    return std::string(bytes).replace(at, 4, Word(value));
  };
  ExpectRefused(LoadBytes(with(4, 1)), "is binary glTF version 1");
  ExpectRefused(LoadBytes(with(8, 0xFFFFFFFF)), "its header says 4294967295 bytes");
  ExpectRefused(LoadBytes(with(12, 0xFFFFFFFF)), "its JSON chunk says 4294967295 bytes");
  ExpectRefused(LoadBytes(with(12, 8)), "JSON cannot be parsed");
  ExpectRefused(LoadBytes(with(16, 0)), "first chunk of the binary glTF is not JSON");
  LoadOptions options = kTouchAll;
  options.max_file_bytes = 100;
  ExpectRefused(LoadBytes(bytes, options), "the limit is 100");
}

TEST(SceneBadInput, RejectsDeepDuplicateAndIncompleteJson) {
  const TempFolder folder;
  const std::string deep = R"({"asset":{"version":"2.0"},"x":)" + std::string(1'000'000, '[');
  ExpectRefused(Load(folder.Write("deep.gltf", deep)), "nested deeper than 128");
  ExpectRefused(Load(folder.Write("twice.gltf", R"({"asset":{"version":"2.0"},"nodes":[],"nodes":[]})")),
                "\"nodes\" appears twice");
  ExpectRefused(Load(folder.Write("list.gltf", "[{}]")), "neither binary glTF");
  ExpectRefused(Load(folder.Write("old.gltf", R"({"asset":{"version":"1.0"}})")), "/asset/version");
  ExpectRefused(Load(folder.Write("bare.gltf", "{}")), "/asset");
}

struct Change {
  const char* at;     // JSON pointer; its value is replaced (or added)
  const char* value;  // JSON
  const char* refusal;
};

TEST(SceneBadInput, ErrorNamesTheInvalidField) {
  const Change kChanges[] = {
      {"/scene", "7", "/scene"},
      {"/scenes/0/nodes", "[0, 0]", "/nodes/0: is reached twice"},
      {"/scenes/0/nodes", "[-1]", "/scenes/0/nodes/0"},
      {"/scenes/0/nodes", "[0.0]", "/scenes/0/nodes/0"},
      {"/scenes/0/nodes", "[]", "nothing to touch"},
      {"/scenes/0/nodes", "{}", "/scenes/0/nodes"},
      {"/nodes", "17", "/nodes"},
      {"/nodes/0", "[]", "/nodes/0"},
      {"/nodes/0/children", "[0]", "/nodes/0: is reached twice"},
      {"/nodes/0/children", "[99]", "/nodes/0/children/0"},
      {"/nodes/0/mesh", "1", "/nodes/0/mesh"},
      {"/nodes/0/mesh", "-1", "/nodes/0/mesh"},
      {"/nodes/0/mesh", "\"0\"", "/nodes/0/mesh"},
      {"/nodes/0/mesh", "1e300", "/nodes/0/mesh"},
      {"/nodes/0/name", "{}", "/nodes/0/name"},
      {"/nodes/0/translation", "[0, 0]", "/nodes/0/translation"},
      {"/nodes/0/translation", "[0, 0, null]", "/nodes/0/translation/2"},
      {"/nodes/0/scale", "[1, 1, 1e308]", "/nodes/0/scale/2"},
      {"/nodes/0/rotation", "[0, 0, 0, 0]", "/nodes/0/rotation"},
      {"/nodes/0/matrix", "[1]", "/nodes/0/matrix"},
      {"/meshes/0", "null", "/meshes/0"},
      {"/meshes/0/primitives", "{}", "/meshes/0/primitives"},
      {"/meshes/0/primitives/0", "[]", "/meshes/0/primitives/0"},
      {"/meshes/0/primitives/0/mode", "7", "/meshes/0/primitives/0/mode"},
      {"/meshes/0/primitives/0/mode", "0", "nothing to touch"},
      {"/meshes/0/primitives/0/material", "5", "/meshes/0/primitives/0/material"},
      {"/meshes/0/primitives/0/indices", "2", "/meshes/0/primitives/0/indices"},
      {"/meshes/0/primitives/0/attributes", "[]", "/meshes/0/primitives/0/attributes"},
      {"/meshes/0/primitives/0/attributes/POSITION", "-2", "/meshes/0/primitives/0/attributes/POSITION"},
      {"/meshes/0/primitives/0/attributes", "{}", "nothing to touch"},
      {"/accessors/0/count", "5", "/accessors/0"},
      {"/accessors/0/count", "-4", "/accessors/0/count"},
      {"/accessors/0/count", "4.0", "/accessors/0/count"},
      {"/accessors/0/count", "18446744073709551615", "/accessors/0/count"},
      {"/accessors/0/count", "3", "names vertex 3 of 3"},
      {"/accessors/0/type", "\"VEC2\"", "/accessors/0/type"},
      {"/accessors/0/componentType", "5125", "/accessors/0/componentType"},
      {"/accessors/0/byteOffset", "4", "/accessors/0"},
      {"/accessors/0/byteOffset", "18446744073709551612", "/accessors/0/byteOffset"},
      {"/accessors/0/normalized", "1", "/accessors/0/normalized"},
      {"/accessors/0/bufferView", "2", "/accessors/0/bufferView"},
      {"/accessors/0/sparse", "{\"count\": 9}", "/accessors/0/sparse/count"},
      {"/accessors/0/sparse", "{\"count\": 1}", "/accessors/0/sparse/indices"},
      {"/accessors/0/sparse",
       "{\"count\": 1, \"indices\": {\"bufferView\": 0, \"byteOffset\": 4, \"componentType\": 5125}, \"values\": "
       "{\"bufferView\": 0}}",
       "sparse index"},
      {"/accessors/1/componentType", "5122", "/accessors/1/componentType"},
      {"/accessors/1/componentType", "5125", "/accessors/1"},
      {"/bufferViews/0/buffer", "1", "/bufferViews/0/buffer"},
      {"/bufferViews/0/byteOffset", "-4", "/bufferViews/0/byteOffset"},
      {"/bufferViews/0/byteLength", "20", "/accessors/0: needs 48 bytes"},
      {"/bufferViews/0/byteStride", "6", "/bufferViews/0/byteStride"},
      {"/bufferViews/0/byteStride", "8", "/bufferViews/0/byteStride"},
      {"/bufferViews/0/byteStride", "256", "/bufferViews/0/byteStride"},
      {"/bufferViews/1/byteOffset", "1099511627776", "/buffers/0"},
      {"/bufferViews/0/extensions", "{\"EXT_meshopt_compression\": {}}",
       "/bufferViews/0/extensions/EXT_meshopt_compression/buffer: is missing"},
      {"/buffers/0/byteLength", "1000", "/buffers/0/byteLength"},
      {"/buffers/0/uri", "\"../secret.bin\"", "/buffers/0/uri: names"},
      {"/buffers/0/uri", "\"%2e%2e%2fsecret.bin\"", "/buffers/0/uri: names"},
      {"/buffers/0/uri", "\"/etc/passwd\"", "/buffers/0/uri: names"},
      {"/buffers/0/uri", "\"http://example.org/a.bin\"", "/buffers/0/uri: names"},
      {"/buffers/0/uri", "\"a%00.bin\"", "/buffers/0/uri: names"},
      {"/buffers/0/uri", "\"missing.bin\"", "/buffers/0/uri"},
      {"/buffers/0/uri", "\"data:text/plain,hello\"", "/buffers/0/uri"},
      {"/buffers/0/uri", "\"data:;base64,AA*A\"", "/buffers/0/uri: is not base64"},
      {"/buffers/0/uri", "\"data:;base64,AAAA\"", "holds 3 bytes"},
      {"/meshes/0/extensions", "{\"MPEG_haptic_material\": {\"hapticMaterialIndex\": 0}}",
       "/meshes/0/extensions/MPEG_haptic_material/hapticMaterialIndex"},
      {"/materials/0/extensions", "[]", "/materials/0/extensions"},
  };
  for (const Change& change : kChanges) {
    Model model = Tetra();
    model.json[Json::json_pointer(change.at)] = Json::parse(change.value);
    SCOPED_TRACE(std::string(change.at) + " = " + change.value);
    ExpectRefused(LoadBytes(model.Bytes()), change.refusal);
  }
}

// Where it is not required, the plain data is there too.
TEST(SceneBadInput, DracoDataIsReadIfRequired) {
  Model model = Tetra();
  model.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  EXPECT_TRUE(LoadBytes(model.Bytes()).result.ok());
  model.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  ExpectRefused(LoadBytes(model.Bytes()),
                "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: its data is no Draco mesh");
}

TEST(SceneBadInput, RejectsNonFinitePositions) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30F}) {
    Model model = Tetra();
    std::vector<float> positions = TetraPositions();
    positions[4] = bad;
    model.bin = Bytes(positions) + Bytes(TetraIndices());
    ExpectRefused(LoadBytes(model.Bytes()), "/accessors/0: vertex 1 is not finite");
    Model unused = Tetra();
    positions = TetraPositions();
    positions.insert(positions.end(), 3, bad);
    const Json five = {{"componentType", 5126}, {"count", 5}, {"type", "VEC3"}};
    unused.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = AddAccessor(unused, Bytes(positions), five);
    EXPECT_TRUE(LoadBytes(unused.Bytes()).result.ok()) << "no triangle has it";
  }
}

TEST(SceneBadInput, LimitsHierarchyDepthAndNodeCount) {
  Model model = Tetra();
  model.json["nodes"] = Json::array();
  for (int i = 0; i < 70; ++i) model.json["nodes"].push_back({{"children", {i + 1}}});
  model.json["nodes"].push_back({{"mesh", 0}});
  ExpectRefused(LoadBytes(model.Bytes()), "/nodes/64: lies deeper than 64 levels");
  LoadOptions options = kTouchAll;
  options.max_depth = 100;
  EXPECT_TRUE(LoadBytes(model.Bytes(), options).result.ok());
  options.max_nodes = 10;
  ExpectRefused(LoadBytes(model.Bytes(), options), "has 71 nodes, the limit is 10");
}

TEST(SceneBadInput, RejectsNodeCyclesWithoutAScene) {
  Model model = Tetra();
  model.json.erase("scene");
  model.json.erase("scenes");
  model.json["nodes"] = Json::parse(R"([{"children": [1]}, {"children": [0], "mesh": 0}])");
  ExpectRefused(LoadBytes(model.Bytes()), "has no root");
}

TEST(SceneBadInput, DoesNotFollowSymlinkedBuffers) {
  const TempFolder folder, elsewhere;
  Model model = Tetra();
  const std::string secret = elsewhere.Write("secret.bin", model.bin);
  std::filesystem::create_symlink(secret, folder.Path("link.bin"));
  model.json["buffers"][0]["uri"] = "link.bin";
  ExpectRefused(Load(folder.Write("a.gltf", model.json.dump())), "/buffers/0/uri");
}

TEST(SceneBadInput, LimitsTrianglesOverAllInstances) {
  Model model = Tetra();
  std::vector<std::uint16_t> indices;
  for (int i = 0; i < 5000; ++i) indices.insert(indices.end(), {0, 1, 2});
  model.bin = Bytes(TetraPositions()) + Bytes(indices);
  model.json["accessors"][1]["count"] = indices.size();
  model.json["bufferViews"][1]["byteLength"] = 2 * indices.size();
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  for (int i = 1; i < 1000; ++i) {
    model.json["nodes"].push_back({{"mesh", 0}});
    model.json["scenes"][0]["nodes"].push_back(i);
  }
  ExpectRefused(LoadBytes(model.Bytes()), "has more than 4000000 triangles");
}

// Refused by its counts, before memory or time is spent; the same for many instances of one.
TEST(SceneBadInput, RejectsFiftyMillionTrianglesImmediately) {
  const TempFolder folder;
  Model model = Tetra();
  model.json["accessors"][1]["count"] = 150'000'000;
  model.json["accessors"][1]["componentType"] = 5125;
  model.json["bufferViews"][1]["byteLength"] = 600'000'000;
  model.json["buffers"][0]["byteLength"] = 600'000'048;
  const std::string huge = folder.Write("huge.glb", model.Bytes());
  Model instanced = Tetra();
  instanced.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 2;
  instanced.json["accessors"].push_back({{"componentType", 5126}, {"count", 3'000'000}, {"type", "VEC3"}});
  const std::string many = folder.Write("many.glb", instanced.Bytes());
  const auto start = std::chrono::steady_clock::now();
  ExpectRefused(Load(huge), "/accessors/1/count: is 150000000: 50000000 triangles, the limit is 4000000");
  ExpectRefused(Load(many), "/nodes/0: with those before, has more than 4000000 triangles");
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_LT(seconds, 0.1);
}

TEST(SceneBadInput, BuildErrorNamesTheNode) {
  const TempFolder folder;
  Model model = Tetra();
  model.json["nodes"][0]["scale"] = {1000, 1000, 1000};
  LoadReport load;
  haptics::BuildReport build;
  const auto scene = LoadScene(folder.Write("far.glb", model.Bytes()), kTouchAll, nullptr, load, build);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().find("far.glb: object 0 \"tetra\" (/nodes/0): vertex"), std::string::npos) << scene.error();
}

TEST(SceneBadInput, RejectsFitOfAZeroSizeModel) {
  Model model = Tetra();
  model.bin = Bytes(std::vector<float>(12, 0.05F)) + Bytes(TetraIndices());
  LoadOptions options = kTouchAll;
  options.fit = true;
  ExpectRefused(LoadBytes(model.Bytes(), options), "cannot be scaled into reach");
}

}  // namespace test_scene_bad_input
}  // namespace omni::scene::test
