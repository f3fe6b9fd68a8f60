// glTF documents of boxes with haptic tags, as bytes in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/scene/files.h"

namespace omni::test {

// A box in the document's frame (y up): its top at `top_m`, half as wide as `half_m`.
struct Box {
  std::string name;
  double half_m, bottom_m, top_m;
  nlohmann::json tag;
};

inline void AddBox(const Box& box, scene::test::Model& model) {
  nlohmann::json& json = model.json;
  const auto h = static_cast<float>(box.half_m), b = static_cast<float>(box.bottom_m),
             t = static_cast<float>(box.top_m);
  const std::vector<float> positions = {-h, b, -h, h, b, -h, h, b, h, -h, b, h, -h, t, -h, h, t, -h, h, t, h, -h, t, h};
  const std::vector<std::uint16_t> indices = {0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6, 0, 4, 5, 0, 5, 1,
                                              1, 5, 6, 1, 6, 2, 2, 6, 7, 2, 7, 3, 3, 7, 4, 3, 4, 0};
  const std::size_t at = model.bin.size(), k = json["accessors"].size();
  model.bin += scene::test::Bytes(positions) + scene::test::Bytes(indices);
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", 96}});
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at + 96}, {"byteLength", 72}});
  json["accessors"].push_back({{"bufferView", k}, {"componentType", 5126}, {"count", 8}, {"type", "VEC3"}});
  json["accessors"].push_back({{"bufferView", k + 1}, {"componentType", 5123}, {"count", 36}, {"type", "SCALAR"}});
  json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", k}}}, {"indices", k + 1}}}}});
  json["nodes"].push_back({{"name", box.name}, {"mesh", json["meshes"].size() - 1}, {"extras", {{"haptic", box.tag}}}});
  json["scenes"][0]["nodes"].push_back(json["nodes"].size() - 1);
  json["buffers"][0]["byteLength"] = model.bin.size();
}

inline std::string Document(const std::vector<Box>& boxes) {
  scene::test::Model model;
  model.json =
      nlohmann::json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
    "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{}]})");
  for (const Box& box : boxes) AddBox(box, model);
  return model.Bytes();
}

}  // namespace omni::test
