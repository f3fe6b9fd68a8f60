#include "service/scene/gltf/instances.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>

#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {

bool IsInstanced(const Json& root, std::uint32_t node) {
  const Json* extensions = FindMember(ElementOf(root, "nodes", node), "extensions");
  return extensions && FindMember(*extensions, kInstancingExtension);
}

std::uint64_t CountInstances(const Json& root, std::uint32_t node) {
  const std::string pointer = JoinPointer("/nodes", node);
  const Json* extensions = FindObject(ElementOf(root, "nodes", node), pointer, "extensions");
  const std::string place = JoinPointer(JoinPointer(pointer, "extensions"), kInstancingExtension);
  const Json* json =
      extensions ? FindObject(*extensions, JoinPointer(pointer, "extensions"), kInstancingExtension) : nullptr;
  if (!json) return 1;
  const Json* attributes = FindObject(*json, place, "attributes");
  std::optional<std::uint64_t> count;
  for (const char* name : {"TRANSLATION", "ROTATION", "SCALE"}) {
    const auto accessor =
        attributes ? ReadIndex(*attributes, JoinPointer(place, "attributes"), name, CountOf(root, "accessors"))
                   : std::nullopt;
    if (!accessor) continue;
    const std::uint64_t own = ReadInteger(ElementOf(root, "accessors", *accessor), JoinPointer("/accessors", *accessor),
                                          "count", haptics::kMaxTriangles, std::nullopt);
    if (count && own != *count) throw LoadError(place, "has attributes of different counts; they must be equal");
    count = own;
  }
  if (!count) throw LoadError(place, "has none of TRANSLATION, ROTATION and SCALE");
  return *count;
}

// X = T R S of each   [EXT_mesh_gpu_instancing]
std::vector<glm::dmat4> PlacesOf(const NodeVisit& node, const DecodedPrimitive& decoded,
                                 const InstancesByNode& instances) {
  const glm::dmat4 placed = decoded.placed ? glm::dmat4(1.0) : node.world;
  const auto own = instances.find(node.node);
  if (own == instances.end()) return {placed};
  std::vector<glm::dmat4> places;
  for (const auto& [t, q, s] : own->second) {
    glm::dmat4 X(1.0);
    const glm::dquat turn(q[3], q[0], q[1], q[2]);
    if (!(glm::length(turn) > 1e-6))
      throw LoadError(node.pointer, "instance " + std::to_string(places.size()) + " has a rotation of zero");
    X[3] = glm::dvec4(t[0], t[1], t[2], 1);
    X = X * glm::mat4_cast(turn / glm::length(turn));
    for (int k = 0; k < 3; ++k) X[k] *= s[static_cast<std::size_t>(k)];
    places.push_back(placed * X);
  }
  return places;
}

namespace {

// Of all nodes together: each is processed by itself, whether it has triangles or not.
constexpr std::uint64_t kMaxParts = 400'000;
constexpr std::uint64_t kMaxStride = 252;  // of a bufferView   [glTF 2.0, 5.11.4]

std::uint64_t StrideOf(const Json& root, const Json& accessor, std::uint64_t packed) {
  const Json* view = FindMember(accessor, "bufferView");
  const std::optional<std::uint64_t> index = view ? view->whole() : std::nullopt;
  if (!index || *index >= CountOf(root, "bufferViews")) return packed;
  const Json* stride = FindMember(ElementOf(root, "bufferViews", static_cast<std::uint32_t>(*index)), "byteStride");
  return std::clamp(stride ? stride->whole().value_or(packed) : packed, packed, std::max(packed, kMaxStride));
}

}  // namespace

std::uint64_t StoredBytes(const Json& root, std::uint32_t accessor, std::uint64_t packed) {
  const Json& json = ElementOf(root, "accessors", accessor);
  const auto count = [](const Json& counted) {
    const Json* found = FindMember(counted, "count");
    return std::min<std::uint64_t>(found ? found->whole().value_or(0) : 0, 1ull << 40);
  };
  const Json* sparse = FindMember(json, "sparse");
  return count(json) * StrideOf(root, json, packed) + (sparse ? count(*sparse) * (4 + packed) : 0);
}

std::vector<PrimitiveSize> SizesOf(const Json& root, std::uint32_t mesh) {
  const std::string pointer = JoinPointer("/meshes", mesh);
  const Json* primitives = FindArray(ElementOf(root, "meshes", mesh), pointer, "primitives");
  const std::uint64_t accessors = CountOf(root, "accessors");
  std::vector<PrimitiveSize> sizes;
  for (std::uint32_t i = 0; primitives && i < primitives->elements().size(); ++i) {
    PrimitiveSize& size = sizes.emplace_back();
    const Json& json = primitives->elements()[i];
    const std::string place = JoinPointer(JoinPointer(pointer, "primitives"), i);
    if (!json.is_object()) throw LoadError(place, "must be an object");
    const std::uint64_t mode = ReadInteger(json, place, "mode", 6, 4);
    auto run = ReadIndex(json, place, "indices", accessors);
    const bool indexed = run.has_value();
    const Json* attributes = FindObject(json, place, "attributes");
    const auto position =
        attributes ? ReadIndex(*attributes, JoinPointer(place, "attributes"), "POSITION", accessors) : std::nullopt;
    if (!run) run = position;
    if (mode < 4 || !run) continue;
    const std::string accessor = JoinPointer("/accessors", *run);
    const std::uint64_t count =
        ReadInteger(ElementOf(root, "accessors", *run), accessor, "count", 1ull << 40, std::nullopt);
    const std::uint64_t triangles = mode == 4 ? count / 3 : (count < 2 ? 0 : count - 2);
    if (triangles > haptics::kMaxTriangles) {
      throw LoadError(JoinPointer(accessor, "count"),
                      "is " + std::to_string(count) + ": " + std::to_string(triangles) + " triangles, the limit is " +
                          std::to_string(haptics::kMaxTriangles) + "; simplify the model");
    }
    size.triangles = triangles;
    size.vertices = 3 * triangles;
    if (indexed) size.bytes = count * StrideOf(root, ElementOf(root, "accessors", *run), 4);
    if (!position) continue;
    const Json& vertices = ElementOf(root, "accessors", *position);
    const Json* vertex_count = FindMember(vertices, "count");
    const std::uint64_t stored =
        std::min<std::uint64_t>(vertex_count ? vertex_count->whole().value_or(0) : 0, 1ull << 40);
    size.vertices = std::min(size.vertices, stored);
    size.bytes += stored * StrideOf(root, vertices, 12);
  }
  return sizes;
}

void CheckTriangleCount(const Json& root, const std::vector<const NodeVisit*>& nodes) {
  struct Size {
    std::uint64_t primitives = 0, triangles = 0;
  };
  std::map<std::uint32_t, Size> of_mesh;
  std::uint64_t parts = 0, sum = 0;
  for (const NodeVisit* node : nodes) {
    const auto [size, fresh] = of_mesh.try_emplace(*node->mesh);
    if (fresh) {
      for (const PrimitiveSize& primitive : SizesOf(root, *node->mesh)) {
        ++size->second.primitives;
        size->second.triangles += primitive.triangles;
      }
    }
    parts += size->second.primitives;
    sum += std::max<std::uint64_t>(size->second.triangles, 1) * CountInstances(root, node->node);
    if (parts > kMaxParts) {
      throw LoadError(node->pointer, "with those before, has more than " + std::to_string(kMaxParts) +
                                         " primitives; join those of one material before exporting");
    }
    if (sum > haptics::kMaxTriangles) {
      throw LoadError(node->pointer, "with those before, has more than " + std::to_string(haptics::kMaxTriangles) +
                                         " triangles; simplify the model or tag only what is touched");
    }
  }
}

}  // namespace omni::scene
