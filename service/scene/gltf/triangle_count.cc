#include "service/scene/gltf/triangle_count.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>

#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/instances.h"
#include "service/scene/gltf/load_error.h"

namespace omni::scene {
namespace {

// Of all nodes together: each is processed by itself, whether it has triangles or not.
constexpr std::uint64_t kMaxParts = 400'000;

std::uint64_t CountPrimitives(const Json& root, std::uint32_t mesh) {
  const Json* primitives = FindArray(ElementOf(root, "meshes", mesh), Join("/meshes", mesh), "primitives");
  return primitives ? primitives->elements().size() : 0;
}

// Of a mesh. Throws LoadError.
std::uint64_t CountTriangles(const Json& root, std::uint32_t mesh) {
  const std::string pointer = Join("/meshes", mesh);
  const Json* primitives = FindArray(ElementOf(root, "meshes", mesh), pointer, "primitives");
  const std::uint64_t accessors = CountOf(root, "accessors");
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; primitives && i < primitives->elements().size(); ++i) {
    const Json& json = primitives->elements()[i];
    const std::string place = Join(Join(pointer, "primitives"), i);
    if (!json.is_object()) throw LoadError(place, "must be an object");
    const std::uint64_t mode = Whole(json, place, "mode", 6, 4);
    auto run = Index(json, place, "indices", accessors);
    const Json* attributes = run ? nullptr : FindObject(json, place, "attributes");
    if (attributes) run = Index(*attributes, Join(place, "attributes"), "POSITION", accessors);
    if (mode < 4 || !run) continue;
    const std::string accessor = Join("/accessors", *run);
    const std::uint64_t count = Whole(ElementOf(root, "accessors", *run), accessor, "count", 1ull << 40, std::nullopt);
    const std::uint64_t triangles = mode == 4 ? count / 3 : (count < 2 ? 0 : count - 2);
    if (triangles > haptics::kMaxTriangles) {
      throw LoadError(Join(accessor, "count"), "is " + std::to_string(count) + ": " + std::to_string(triangles) +
                                                   " triangles, the limit is " +
                                                   std::to_string(haptics::kMaxTriangles) + "; simplify the model");
    }
    sum += triangles;
  }
  return sum;
}

}  // namespace

void CheckTriangleCount(const Json& root, const std::vector<const NodeVisit*>& nodes) {
  struct Size {
    std::uint64_t primitives, triangles;
  };
  std::map<std::uint32_t, Size> of_mesh;
  std::uint64_t parts = 0, sum = 0;
  for (const NodeVisit* node : nodes) {
    const auto [size, fresh] = of_mesh.try_emplace(*node->mesh);
    if (fresh) size->second = {CountPrimitives(root, *node->mesh), CountTriangles(root, *node->mesh)};
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
