// A small writer of binary glTF: what our scenes need, the same bytes on every run.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scenes/generator/mesh/mesh.h"

namespace omni::scenes {

using OrderedJson = nlohmann::ordered_json;

struct OutMaterial {
  std::string name;
  Vec colour{0.8, 0.8, 0.8};  // linear
  double roughness = 0.7;
  double metallic = 0;
  OrderedJson extensions = nullptr;
  OrderedJson extras = nullptr;
};

struct OutMesh {
  std::string name;
  Mesh mesh;  // group g is drawn with materials[g]
  std::vector<std::uint32_t> materials;
  OrderedJson extensions = nullptr;
};

struct OutNode {
  std::string name;
  std::optional<std::uint32_t> mesh;
  Vec translation_base_m{0.0};
  double heading_rad = 0;               // about the base's z
  OrderedJson haptic = nullptr;         // becomes extras.haptic
  std::vector<std::uint32_t> children;  // each node has at most one parent
};

struct Document {  // NOLINT(bugprone-exception-escape): the JSON library's move is noexcept and only asserts
  std::string title;
  std::vector<OutMaterial> materials;
  std::vector<OutMesh> meshes;
  std::vector<OutNode> nodes;
  OrderedJson extensions = nullptr;  // of the root
  std::vector<std::string> extensions_used;
};

// Base frame (z up) -> glTF (y up): (x, y, z) -> (x, z, -y).
std::vector<unsigned char> WriteGlb(const Document& document);

}  // namespace omni::scenes
