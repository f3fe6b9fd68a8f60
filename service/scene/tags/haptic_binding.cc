#include "service/scene/tags/haptic_binding.h"

#include "service/scene/gltf/json_reading.h"
#include "service/scene/tags/haptic_texture.h"

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
  return extensions ? FindObject(*extensions, JoinPointer(pointer, "extensions"), name) : nullptr;
}

const HapticTag kNoTag;

std::string PlaceOf(const std::string& pointer, const char* extension) {
  return JoinPointer(JoinPointer(pointer, "extensions"), extension);
}

}  // namespace

template <class Read>
const HapticTag& Binding::Cached(const std::string& key, Read read) {
  const auto [place, fresh] = cache_.try_emplace(key);
  if (fresh) {
    if (HapticTag tag = read(); tag.present) place->second = std::make_unique<const HapticTag>(std::move(tag));
  }
  return place->second ? *place->second : kNoTag;
}

const HapticTag& Binding::MpegMaterial(const char* extension, const Json& user, const std::string& pointer,
                                       const char* key) {
  const std::string place = PlaceOf("", extension);
  const Json* mpeg = Extension(root_, "", extension);
  const Json* materials = mpeg ? FindArray(*mpeg, place, "materials") : nullptr;
  const auto index = ReadIndex(user, pointer, key, materials ? materials->elements().size() : 0);
  if (!index || materials == nullptr) throw LoadError(JoinPointer(pointer, key), "is missing");
  const std::string material = JoinPointer(JoinPointer(place, "materials"), *index);
  return Cached(material, [&] {
    const Json& json = materials->elements()[*index];
    if (!json.is_object()) throw LoadError(material, "must be an object");
    for (const char* texture : {"haptic", "temperature", "vibration", "custom"}) {
      if (FindMember(json, texture)) warnings_.Add(JoinPointer(material, texture), "is not rendered");
    }
    HapticTag tag;
    if (const Json* omni = Extension(json, material, kOmni)) tag = ReadTag(*omni, PlaceOf(material, kOmni), warnings_);
    for (const auto& [name, role] : kTextureKeys) {
      const Json* list = FindMember(json, name);
      if (!list) continue;
      if (auto use = ReadTextureUse(root_, *list, JoinPointer(material, name), warnings_))
        tag.textures[role] = std::make_shared<const TextureUse>(std::move(*use));
    }
    tag.present = true;
    return tag;
  });
}

const HapticTag& Binding::MeshExtension(std::uint32_t mesh) {
  const std::string pointer = JoinPointer("/meshes", mesh);
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
  const std::string pointer = JoinPointer("/materials", material);
  return Cached(pointer + "/extensions", [&] {
    HapticTag tag;
    const Json* omni = Extension(ElementOf(root_, "materials", material), pointer, kOmni);
    if (!omni) return tag;
    const std::string place = PlaceOf(pointer, kOmni);
    if (FindMember(*omni, "material")) {
      const char* spelling = Extension(root_, "", kMpegSpellings[0]) ? kMpegSpellings[0] : kMpegSpellings[1];
      tag = MpegMaterial(spelling, *omni, place, "material");
    }
    tag.OverrideBy(ReadTag(*omni, place, warnings_, "material"));
    return tag;
  });
}

const HapticTag& Binding::MeshExtras(std::uint32_t mesh) {
  const std::string pointer = JoinPointer("/meshes", mesh);
  return Cached(pointer, [&] { return ReadExtras(ElementOf(root_, "meshes", mesh), pointer, warnings_); });
}

const HapticTag& Binding::MaterialExtras(std::uint32_t material) {
  const std::string pointer = JoinPointer("/materials", material);
  return Cached(pointer, [&] {
    const Json& json = ElementOf(root_, "materials", material);
    HapticTag tag = ReadExtras(json, pointer, warnings_);
    named_.OverrideNamed(json, tag);
    return tag;
  });
}

const HapticTag& Binding::Physics(const NodeVisit& node) {
  const Json* body = Extension(ElementOf(root_, "nodes", node.node), node.pointer, kPhysics);
  const std::string place = PlaceOf(node.pointer, kPhysics);
  const Json* collider = body ? FindObject(*body, place, "collider") : nullptr;
  if (!collider) return kNoTag;
  return Cached(node.pointer + "/extensions", [&] {
    HapticTag tag;
    tag.present = true;
    const Json* physics = Extension(root_, "", kPhysics);
    const std::string root_place = PlaceOf("", kPhysics);
    const Json* materials = physics ? FindArray(*physics, root_place, "physicsMaterials") : nullptr;
    const auto index = ReadIndex(*collider, JoinPointer(place, "collider"), "physicsMaterial",
                                 materials ? materials->elements().size() : 0);
    if (!index || !materials) return tag;
    return ReadNumbers(materials->elements()[*index], {"staticFriction", "dynamicFriction", "restitution"},
                       JoinPointer(JoinPointer(root_place, "physicsMaterials"), *index), warnings_);
  });
}

std::optional<std::uint32_t> Binding::MaterialOfPrimitive(std::uint32_t mesh, std::uint32_t primitive) {
  const std::string pointer = JoinPointer("/meshes", mesh);
  const Json* primitives = FindArray(ElementOf(root_, "meshes", mesh), pointer, "primitives");
  if (!primitives || primitive >= primitives->elements().size()) return std::nullopt;
  return ReadIndex(primitives->elements()[primitive], JoinPointer(JoinPointer(pointer, "primitives"), primitive),
                   "material", CountOf(root_, "materials"));
}

bool Binding::MeshTagged(std::uint32_t mesh) {
  if (MeshExtras(mesh).present || MeshExtension(mesh).present) return true;
  const Json* primitives = FindMember(ElementOf(root_, "meshes", mesh), "primitives");
  for (std::uint32_t i = 0; primitives && i < primitives->elements().size(); ++i) {
    const auto material = MaterialOfPrimitive(mesh, i);
    if (material && (MaterialExtras(*material).present || MaterialExtension(*material).present)) return true;
  }
  return false;
}

bool Binding::HasTag(const NodeVisit& node) {
  if (node.inherited->present || Physics(node).present) return true;
  if (!node.mesh) return false;
  // Once a mesh: a hundred thousand nodes may show one of a hundred thousand primitives.
  const auto known = tagged_meshes_.find(*node.mesh);
  if (known != tagged_meshes_.end()) return known->second;
  return tagged_meshes_[*node.mesh] = MeshTagged(*node.mesh);
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
  const double relief = tag.material.Get(base::IndexOfKey(base::kMaterialFields, "relief")).value_or(0);
  if (material && relief > 0) tag.textures[kRelief] = NormalTexture(*material);
  return tag;
}

std::shared_ptr<const TextureUse> Binding::NormalTexture(std::uint32_t material) {
  const auto [place, fresh] = normal_textures_.try_emplace(material);
  if (fresh) {
    auto use = ReadNormalTexture(root_, ElementOf(root_, "materials", material), JoinPointer("/materials", material),
                                 warnings_);
    if (use) place->second = std::make_shared<const TextureUse>(std::move(*use));
  }
  return place->second;
}

std::uint16_t Binding::MaterialIndex(const haptics::Material& material, const std::string& pointer) {
  const auto [number, fresh] = numbers_.try_emplace(FieldsOf(material), static_cast<std::uint16_t>(materials_.size()));
  if (!fresh) return number->second;
  constexpr std::size_t kMaxMaterials = 4096;
  if (materials_.size() == kMaxMaterials) {
    throw LoadError(pointer, "is haptic material " + std::to_string(kMaxMaterials + 1) + ", the limit is " +
                                 std::to_string(kMaxMaterials) + "; let meshes share materials");
  }
  materials_.push_back(material);
  return number->second;
}

}  // namespace omni::scene
