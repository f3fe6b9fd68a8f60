#include "service/scene/gltf/mesh_requests.h"

#include <cmath>
#include <string>
#include <utility>

#include "service/scene/gltf/instances.h"

namespace omni::scene {
namespace {

constexpr std::uint64_t kMaxJoints = 100'000;  // of all skins: each takes two matrices
constexpr std::size_t kMaxMorphs = 64;         // targets with a weight, of one mesh: each moves all of its vertices
constexpr double kMostWeight = 1e6;
constexpr std::uint64_t kJointBytes = 200;  // half of two matrices, its stored one and some room
constexpr std::uint64_t kMorphBytes = 64;

// Those that are not 0.
std::vector<MorphWeight> ReadWeights(const Json& owner, const std::string& pointer) {
  std::vector<MorphWeight> weights;
  const Json* array = FindArray(owner, pointer, "weights");
  if (!array) return weights;
  const std::string place = JoinPointer(pointer, "weights");
  for (std::size_t i = 0; i < array->elements().size(); ++i) {
    const Json& element = array->elements()[i];
    const double weight = element.number();
    if (!(std::abs(weight) <= kMostWeight))
      throw LoadError(JoinPointer(place, i), "is " + ValueText(element) + ", must be a number within +-1e6");
    if (weight == 0) continue;
    if (weights.size() == kMaxMorphs) {
      throw LoadError(place, "has more than " + std::to_string(kMaxMorphs) +
                                 " weights that are not 0; apply shape keys before exporting");
    }
    weights.push_back({static_cast<std::uint32_t>(i), weight});
  }
  return weights;
}

}  // namespace

// A node's own weights before those of its mesh   [glTF 2.0, 3.7.2.2]
const std::vector<MorphWeight>& MeshRequests::MorphOf(const NodeVisit& node, std::vector<MorphWeight>& own) {
  const Json& json = ElementOf(root_, "nodes", node.node);
  if (FindMember(json, "weights")) return own = ReadWeights(json, node.pointer);
  const auto [place, fresh] = mesh_weights_.try_emplace(*node.mesh);
  if (fresh) place->second = ReadWeights(ElementOf(root_, "meshes", *node.mesh), JoinPointer("/meshes", *node.mesh));
  return place->second;
}

std::size_t MeshRequests::SkinOf(std::uint32_t skin) {
  const auto [number, fresh] = skin_numbers_.try_emplace(skin, skins_.size());
  if (!fresh) return number->second;
  if (by_node_.empty()) {
    by_node_.resize(static_cast<std::size_t>(CountOf(root_, "nodes")));
    for (const NodeVisit& node : nodes_) by_node_[node.node] = &node;
  }
  const std::string pointer = JoinPointer("/skins", skin), place = JoinPointer(pointer, "joints");
  const Json* joints = FindArray(ElementOf(root_, "skins", skin), pointer, "joints");
  if (!joints || joints->elements().empty()) throw LoadError(place, "is missing; a skin has at least one joint");
  joints_ += joints->elements().size();
  if (joints_ > kMaxJoints) {
    throw LoadError(place, "with those of other skins, has more than " + std::to_string(kMaxJoints) +
                               " joints; apply the armature before exporting");
  }
  SkinRequest request{.skin = skin, .joints = {}};
  request.joints.reserve(joints->elements().size());
  for (std::size_t i = 0; i < joints->elements().size(); ++i) {
    const std::uint32_t node = IndexIn(joints->elements()[i], JoinPointer(place, i), by_node_.size());
    if (by_node_[node] == nullptr) {
      throw LoadError(JoinPointer(place, i), "is node " + std::to_string(node) +
                                                 ", which is not in the scene that is loaded; export the file again");
    }
    request.joints.push_back(by_node_[node]->world);
  }
  skins_.push_back(std::move(request));
  return number->second;
}

std::size_t MeshRequests::Add(const NodeVisit& node) {
  std::vector<MorphWeight> own;
  const std::vector<MorphWeight>& morph = MorphOf(node, own);
  const std::optional<std::size_t> skin = node.skin ? std::optional(SkinOf(*node.skin)) : std::nullopt;
  const auto [number, fresh] = numbers_.try_emplace(Key{*node.mesh, skin, morph}, meshes_.size());
  if (fresh) meshes_.push_back({.mesh = *node.mesh, .skin = skin, .morph = morph, .uv_sets = {}});
  return number->second;
}

std::uint64_t MeshRequests::ShapeBytes(const MeshRequest& request) const {
  std::uint64_t bytes = request.morph.size() * kMorphBytes;
  if (request.skin) bytes += skins_[*request.skin].joints.size() * kJointBytes;
  if (!request.skin && request.morph.empty()) return bytes;
  const std::uint64_t accessors = CountOf(root_, "accessors");
  const Json* primitives = FindMember(ElementOf(root_, "meshes", request.mesh), "primitives");
  for (const Json& primitive : primitives ? primitives->elements() : std::span<const Json>()) {
    const auto add = [&](const Json* owner, const std::string& name, std::uint64_t packed) {
      const Json* index = owner ? FindMember(*owner, name) : nullptr;
      const std::uint64_t accessor = index ? index->whole().value_or(accessors) : accessors;
      if (accessor < accessors) bytes += StoredBytes(root_, static_cast<std::uint32_t>(accessor), packed);
      return index != nullptr;
    };
    const Json* attributes = FindMember(primitive, "attributes");
    for (std::size_t set = 0; request.skin; ++set) {
      const bool joints = add(attributes, "JOINTS_" + std::to_string(set), 8);
      const bool weights = add(attributes, "WEIGHTS_" + std::to_string(set), 16);
      if (!joints || !weights) break;
    }
    const Json* targets = FindMember(primitive, "targets");
    for (const auto& [target, weight] : request.morph) {
      if (targets && target < targets->elements().size()) add(&targets->elements()[target], "POSITION", 12);
    }
  }
  return bytes;
}

}  // namespace omni::scene
