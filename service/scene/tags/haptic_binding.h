// Which haptic material a primitive of a node has: all places where a glTF file can specify it, in order of precedence.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/haptics/scene/scene_input.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/node_tree.h"
#include "service/scene/tags/haptic_tag.h"

namespace omni::scene {

// Weakest first; each overrides the ones before it key by key:
//   defaults < extras of ancestors, node, mesh, material < KHR_physics_rigid_bodies (friction, restitution)
//   < mesh MPEG_haptic_material / MPEG_material_haptic < material OMNI_haptic_material
// Tags by name count as extras of the material, or of the node.
class Binding {
 public:
  // All outlive this.
  Binding(const Json& root, const NamedTags& named, Warnings& warnings)
      : root_(root), named_(named), warnings_(warnings) {}

  // Whether the mesh of this node has a tag at any of these places.
  bool HasTag(const NodeVisit& node);

  // Whether the node itself has one: no ancestor, and no mesh or material, which others may share.
  bool HasOwnTag(const NodeVisit& node) { return node.own || Physics(node).present; }

  // The tag that holds for primitive `primitive` of the node's mesh.
  HapticTag TagOf(const NodeVisit& node, std::uint32_t primitive);

  // Index of a material; equal ones share one. Throws LoadError over 4,096 of them.
  std::uint16_t MaterialIndex(const haptics::Material& material, const std::string& pointer);
  std::vector<haptics::Material> TakeMaterials() { return std::move(materials_); }

 private:
  const HapticTag& MeshExtras(std::uint32_t mesh);
  const HapticTag& MeshExtension(std::uint32_t mesh);
  const HapticTag& MaterialExtras(std::uint32_t material);
  const HapticTag& MaterialExtension(std::uint32_t material);
  const HapticTag& Physics(const NodeVisit& node);
  const HapticTag& MpegMaterial(const char* extension, const Json& user, const std::string& pointer, const char* key);
  std::shared_ptr<const TextureUse> NormalTexture(std::uint32_t material);
  std::optional<std::uint32_t> MaterialOfPrimitive(std::uint32_t mesh, std::uint32_t primitive);
  bool MeshTagged(std::uint32_t mesh);

  template <class Read>
  const HapticTag& Cached(const std::string& key, Read read);

  const Json& root_;
  const NamedTags& named_;
  Warnings& warnings_;
  std::map<std::string, std::unique_ptr<const HapticTag>> cache_;  // each place is read, and warned about, once
  std::map<std::uint32_t, bool> tagged_meshes_;
  std::map<std::uint32_t, std::shared_ptr<const TextureUse>> normal_textures_;  // by material; null: none
  std::vector<haptics::Material> materials_;
  std::map<std::vector<double>, std::uint16_t> numbers_;  // of materials_, by their fields
};

}  // namespace omni::scene
