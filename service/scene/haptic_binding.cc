#include "service/scene/haptic_binding.h"

#include <nlohmann/json.hpp>

#include "service/scene/haptic_texture.h"
#include "service/scene/load_error.h"

namespace omni::scene {
namespace {

constexpr const char* kOmni = "OMNI_haptic_material";
constexpr const char* kPhysics = "KHR_physics_rigid_bodies";
// The draft of 2023 and the one of 2025 spell it differently; files of both exist.
constexpr const char* kMpegSpellings[] = {"MPEG_haptic_material", "MPEG_material_haptic"};

struct TextureKey {
  const char* key;
  TextureRole role;
};
constexpr TextureKey kTextureKeys[] = {{"stiffness", kStiffnessTexture},
                                       {"friction", kFrictionTexture},
                                       {"vibrotactile_texture", kVibrotactileTexture},  // the draft of 2023
                                       {"vibrotactileTexture", kVibrotactileTexture}};

const Json* Extension(const Json& owner, const std::string& pointer, const char* name) {
  const Json* extensions = FindObject(owner, pointer, "extensions");
  return extensions ? FindObject(*extensions, Join(pointer, "extensions"), name) : nullptr;
}

std::string PlaceOf(const std::string& pointer, const char* extension) {
  return Join(Join(pointer, "extensions"), extension);
}

}  // namespace

const HapticTag& Binding::MpegMaterial(const char* extension, const Json& user, const std::string& pointer,
                                       const char* key) {
  const std::string place = PlaceOf("", extension);
  const Json* mpeg = Extension(root_, "", extension);
  const Json* materials = mpeg ? FindArray(*mpeg, place, "materials") : nullptr;
  const auto index = Index(user, pointer, key, materials ? materials->size() : 0);
  if (!index) throw LoadError(Join(pointer, key), "is missing");
  const std::string material = Join(Join(place, "materials"), *index);
  return Cached(material, [&] {
    const Json& json = (*materials)[*index];
    if (!json.is_object()) throw LoadError(material, "must be an object");
    for (const char* texture : {"haptic", "temperature", "vibration", "custom"}) {
      if (Find(json, texture)) warnings_.Add(Join(material, texture), "is not rendered");
    }
    HapticTag tag;
    if (const Json* omni = Extension(json, material, kOmni)) tag = ReadTag(*omni, PlaceOf(material, kOmni), warnings_);
    for (const auto& [name, role] : kTextureKeys) {
      const Json* list = Find(json, name);
      if (!list) continue;
      if (auto use = ReadTextureUse(root_, *list, Join(material, name), warnings_)) tag.textures[role] = std::move(use);
    }
    tag.present = true;
    return tag;
  });
}

const HapticTag& Binding::MeshExtension(std::uint32_t mesh) {
  const std::string pointer = Join("/meshes", mesh);
  return Cached(pointer + "/extensions", [&] {
    HapticTag tag;
    const Json& json = ElementOf(root_, "meshes", mesh);
    for (const char* name : kMpegSpellings) {
      const Json* user = Extension(json, pointer, name);
      if (user) tag.OverrideBy(MpegMaterial(name, *user, PlaceOf(pointer, name), "hapticMaterialIndex"));
    }
    return tag;
  });
}

const HapticTag& Binding::MaterialExtension(std::uint32_t material) {
  const std::string pointer = Join("/materials", material);
  return Cached(pointer + "/extensions", [&] {
    HapticTag tag;
    const Json* omni = Extension(ElementOf(root_, "materials", material), pointer, kOmni);
    if (!omni) return tag;
    const std::string place = PlaceOf(pointer, kOmni);
    if (Find(*omni, "material")) {
      const char* spelling = Extension(root_, "", kMpegSpellings[0]) ? kMpegSpellings[0] : kMpegSpellings[1];
      tag = MpegMaterial(spelling, *omni, place, "material");
    }
    Json own = *omni;
    own.erase("material");
    tag.OverrideBy(ReadTag(own, place, warnings_));
    return tag;
  });
}

const HapticTag& Binding::MeshExtras(std::uint32_t mesh) {
  const std::string pointer = Join("/meshes", mesh);
  return Cached(pointer, [&] { return ReadExtras(ElementOf(root_, "meshes", mesh), pointer, warnings_); });
}

const HapticTag& Binding::MaterialExtras(std::uint32_t material) {
  const std::string pointer = Join("/materials", material);
  return Cached(pointer, [&] { return ReadExtras(ElementOf(root_, "materials", material), pointer, warnings_); });
}

const HapticTag& Binding::Physics(const NodeVisit& node) {
  return Cached(node.pointer + "/extensions", [&] {
    HapticTag tag;
    const Json* body = Extension(ElementOf(root_, "nodes", node.node), node.pointer, kPhysics);
    const std::string place = PlaceOf(node.pointer, kPhysics);
    const Json* collider = body ? FindObject(*body, place, "collider") : nullptr;
    if (!collider) return tag;
    tag.present = true;
    const Json* physics = Extension(root_, "", kPhysics);
    const std::string root_place = PlaceOf("", kPhysics);
    const Json* materials = physics ? FindArray(*physics, root_place, "physicsMaterials") : nullptr;
    const auto index = Index(*collider, Join(place, "collider"), "physicsMaterial", materials ? materials->size() : 0);
    if (!index || !materials) return tag;
    Json known = Json::object();
    for (const char* key : {"staticFriction", "dynamicFriction", "restitution"}) {
      if (const Json* value = Find((*materials)[*index], key)) known[key] = *value;
    }
    return ReadTag(known, Join(Join(root_place, "physicsMaterials"), *index), warnings_);
  });
}

std::optional<std::uint32_t> Binding::MaterialOfPrimitive(std::uint32_t mesh, std::uint32_t primitive) {
  const std::string pointer = Join("/meshes", mesh);
  const Json* primitives = FindArray(ElementOf(root_, "meshes", mesh), pointer, "primitives");
  if (!primitives || primitive >= primitives->size()) return std::nullopt;
  return Index((*primitives)[primitive], Join(Join(pointer, "primitives"), primitive), "material",
               CountOf(root_, "materials"));
}

bool Binding::Tagged(const NodeVisit& node) {
  if (node.inherited->present || Physics(node).present) return true;
  if (!node.mesh) return false;
  if (MeshExtras(*node.mesh).present || MeshExtension(*node.mesh).present) return true;
  const Json* primitives = Find(ElementOf(root_, "meshes", *node.mesh), "primitives");
  for (std::uint32_t i = 0; primitives && i < primitives->size(); ++i) {
    const auto material = MaterialOfPrimitive(*node.mesh, i);
    if (material && (MaterialExtras(*material).present || MaterialExtension(*material).present)) return true;
  }
  return false;
}

HapticTag Binding::TagOf(const NodeVisit& node, std::uint32_t primitive) {
  HapticTag tag = *node.inherited;
  if (!node.mesh) return tag;
  const auto material = MaterialOfPrimitive(*node.mesh, primitive);
  tag.OverrideBy(MeshExtras(*node.mesh));
  if (material) tag.OverrideBy(MaterialExtras(*material));
  tag.OverrideBy(Physics(node));
  tag.OverrideBy(MeshExtension(*node.mesh));
  if (material) tag.OverrideBy(MaterialExtension(*material));
  return tag;
}

std::uint16_t Binding::MaterialIndex(const haptics::Material& material, const std::string& pointer) {
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    if (SameMaterial(materials_[i], material)) return static_cast<std::uint16_t>(i);
  }
  constexpr std::size_t kMaxMaterials = 4096;
  if (materials_.size() == kMaxMaterials) {
    throw LoadError(pointer, "is haptic material " + std::to_string(kMaxMaterials + 1) + ", the limit is " +
                                 std::to_string(kMaxMaterials) + "; let meshes share materials");
  }
  materials_.push_back(material);
  return static_cast<std::uint16_t>(materials_.size() - 1);
}

}  // namespace omni::scene
