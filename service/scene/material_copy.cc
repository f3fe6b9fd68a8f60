#include "service/scene/material_copy.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "service/base/files/whole_file.h"
#include "service/scene/glb_save.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

using Node = nlohmann::json;

constexpr const char* kExtension = "OMNI_haptic_material";
constexpr std::size_t kMaxBytes = 1ull << 30;  // as LoadOptions

struct Problem {
  std::string text;
};

std::uint32_t WordAt(const std::string& bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof(word));
  return word;
}

struct Glb {
  Node document;
  std::string rest;  // chunks after the first
};

Glb ReadGlb(const std::string& path) {
  const base::Result<std::string> bytes = base::ReadFile(path, kMaxBytes);
  if (!bytes.ok()) throw Problem{bytes.error()};
  constexpr std::size_t kHead = 20;
  const bool binary = bytes->size() >= kHead && bytes->substr(0, 4) == "glTF" && WordAt(*bytes, 16) == kJsonChunk;
  if (!binary) throw Problem{path + ": is no binary glTF file (.glb); export it as one"};
  const std::size_t json_bytes = WordAt(*bytes, 12);
  if (json_bytes > bytes->size() - kHead) throw Problem{path + ": is cut off within its JSON; export it again"};
  const std::string text = bytes->substr(kHead, json_bytes);
  if (const base::Status checked = base::CheckJson(text, kSceneJson); !checked.ok()) {
    throw Problem{path + ": " + checked.error()};
  }
  return {nlohmann::json::parse(text), bytes->substr(kHead + json_bytes)};
}

using Primitive = std::pair<std::uint32_t, std::uint32_t>;  // mesh, its number there

class Copier {
 public:
  Copier(Node& document, std::span<const ChangedMaterial> changed) : document_(document) {
    for (const ChangedMaterial& material : changed) changed_[material.material] = &material.values;
  }

  void Run(std::span<const MaterialUse> uses, const std::string& path) {
    std::map<Primitive, std::uint16_t> haptic_of;
    for (const MaterialUse& use : uses) {
      const auto [found, fresh] = haptic_of.emplace(Primitive{use.mesh, use.primitive}, use.material);
      if (!fresh && found->second != use.material &&
          (changed_.count(use.material) + changed_.count(found->second)) > 0) {
        throw Problem{
            path + ": /meshes/" + std::to_string(use.mesh) +
            " has different haptic materials at several nodes, and a mesh can keep one; give each node a mesh"};
      }
    }
    std::map<std::int64_t, std::set<std::uint16_t>> haptics_of;  // of a glTF material; -1: none
    for (const auto& [primitive, haptic] : haptic_of) haptics_of[MaterialOf(primitive)].insert(haptic);
    for (const auto& [primitive, haptic] : haptic_of) {
      if (changed_.count(haptic) == 0) continue;
      const std::int64_t material = MaterialOf(primitive);
      const bool alone = material >= 0 && haptics_of.at(material).size() == 1;
      PrimitiveOf(primitive)["material"] = alone ? Tag(material, haptic) : Tag(CopyOf(material, haptic), haptic);
    }
    Node& used = document_["extensionsUsed"];
    if (!used.is_array()) used = Node::array();
    if (std::find(used.begin(), used.end(), kExtension) == used.end()) used.push_back(kExtension);
  }

 private:
  Node& PrimitiveOf(const Primitive& primitive) {
    return document_.at("meshes").at(primitive.first).at("primitives").at(primitive.second);
  }
  std::int64_t MaterialOf(const Primitive& primitive) {
    const Node& of = PrimitiveOf(primitive);
    return of.contains("material") ? of.at("material").get<std::int64_t>() : -1;
  }
  std::int64_t CopyOf(std::int64_t material, std::uint16_t haptic) {
    const auto [found, fresh] = copies_.try_emplace({material, haptic}, 0);
    if (!fresh) return found->second;
    Node& materials = document_["materials"];
    if (!materials.is_array()) materials = Node::array();
    Node copy = material >= 0 ? materials.at(static_cast<std::size_t>(material)) : Node::object();
    materials.push_back(std::move(copy));
    return found->second = static_cast<std::int64_t>(materials.size()) - 1;
  }
  std::int64_t Tag(std::int64_t material, std::uint16_t haptic) {
    Node& tag = document_.at("materials").at(static_cast<std::size_t>(material))["extensions"][kExtension];
    if (!tag.is_object()) tag = Node::object();
    for (const base::MaterialField* field : base::kLiveFields) {
      PutKey(field->key, changed_.at(haptic)->*field->live, tag);
    }
    return material;
  }

  Node& document_;
  std::map<std::uint16_t, const base::MaterialParameters*> changed_;
  std::map<std::pair<std::int64_t, std::uint16_t>, std::int64_t> copies_;
};

}  // namespace

base::Result<std::string> GlbWithMaterials(const std::string& path, std::span<const MaterialUse> uses,
                                           std::span<const ChangedMaterial> changed) {
  try {
    Glb glb = ReadGlb(path);
    Copier(glb.document, changed).Run(uses, path);
    return GlbFile(glb.document.dump(), glb.rest);
  } catch (const Problem& problem) {
    return base::Error{problem.text};
  } catch (const Node::exception& error) {
    return base::Error{path + ": " + error.what() + "; the file has changed since it was loaded"};
  }
}

}  // namespace omni::scene
