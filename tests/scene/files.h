// Small glTF files for the tests of service/scene.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "service/scene/scene_file.h"
#include "tests/support/process/temp_folder.h"

namespace omni::scene::test {

using Json = nlohmann::json;

using omni::test::TempFolder;

template <class T>
std::string Bytes(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

inline std::string Word(std::uint32_t value) { return Bytes(std::vector<std::uint32_t>{value}); }

inline std::string Glb(const Json& json, std::string bin) {
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  bin.resize((bin.size() + 3) / 4 * 4, '\0');
  const auto length = static_cast<std::uint32_t>(28 + text.size() + bin.size());
  return "glTF" + Word(2) + Word(length) + Word(static_cast<std::uint32_t>(text.size())) + "JSON" + text +
         Word(static_cast<std::uint32_t>(bin.size())) + std::string("BIN\0", 4) + bin;
}

inline std::string ReadAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Corners of a tetrahedron of positive volume in the glTF frame, 10 mm wide, 45 to 55 mm above the core's centre.
inline std::vector<float> TetraPositions() {
  return {0.0F, 0.045F, 0.0F, 0.01F, 0.045F, 0.0F, 0.0F, 0.055F, 0.0F, 0.0F, 0.045F, 0.01F};
}
inline std::vector<std::uint16_t> TetraIndices() { return {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}; }

struct Model {  // NOLINT(bugprone-exception-escape): the JSON library's move is noexcept and only asserts
  Json json;
  std::string bin;
  std::string Bytes() const { return Glb(json, bin); }
};

// One node, one mesh, one primitive: the tetrahedron.
inline Model Tetra() {
  Model model;
  model.bin = Bytes(TetraPositions()) + Bytes(TetraIndices());
  model.json = Json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "tetra", "mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "materials": [{"name": "plain"}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "buffers": [{"byteLength": 72}]})");
  return model;
}

// An accessor over bytes behind those that the model has.
inline std::size_t AddAccessor(Model& model, const std::string& bytes, Json accessor) {
  model.bin.resize((model.bin.size() + 3) / 4 * 4, '\0');
  accessor["bufferView"] = model.json["bufferViews"].size();
  model.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", model.bin.size()}, {"byteLength", bytes.size()}});
  model.bin += bytes;
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  model.json["accessors"].push_back(std::move(accessor));
  return model.json["accessors"].size() - 1;
}

inline double SignedVolume6(const haptics::InputObject& object) {
  double sum = 0;
  for (const auto& [i, j, k] : object.triangles) {
    const base::Vec3 &a = object.vertices_base_m[i], &b = object.vertices_base_m[j], &c = object.vertices_base_m[k];
    sum += a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
  }
  return sum;
}

struct Loaded {
  base::Result<haptics::SceneInput> result = base::Error{"not loaded"};
  LoadReport report;
  haptics::SceneInput& scene() { return result.value(); }
  std::string Warnings() const {
    std::string all;
    for (const std::string& line : report.warnings) all += line + "\n";
    return all;
  }
};

// Everything is touched unless the test says otherwise.
inline const LoadOptions kTouchAll{.touch_untagged = true};

inline Loaded Load(const std::string& path, const LoadOptions& options = kTouchAll) {
  Loaded loaded;
  loaded.result = LoadSceneFile(path, options, loaded.report);
  return loaded;
}

inline Loaded LoadBytes(const std::string& bytes, const LoadOptions& options = kTouchAll) {
  const TempFolder folder;
  return Load(folder.Write("model.glb", bytes), options);
}

}  // namespace omni::scene::test
