#include "service/scene/triangle_count.h"

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "service/haptics/scene.h"
#include "service/scene/instances.h"
#include "service/scene/load_error.h"

namespace omni::scene {
namespace {

// Of a mesh. Throws LoadError.
std::uint64_t CountTriangles(const Json& root, std::uint32_t mesh) {
  const std::string pointer = Join("/meshes", mesh);
  const Json* primitives = FindArray(ElementOf(root, "meshes", mesh), pointer, "primitives");
  const std::uint64_t accessors = CountOf(root, "accessors");
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; primitives && i < primitives->size(); ++i) {
    const Json& json = (*primitives)[i];
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
  std::map<std::uint32_t, std::uint64_t> of_mesh;
  std::uint64_t sum = 0;
  for (const NodeVisit* node : nodes) {
    const auto found = of_mesh.find(*node->mesh);
    const std::uint64_t triangles = found != of_mesh.end()
                                        ? found->second
                                        : of_mesh.emplace(*node->mesh, CountTriangles(root, *node->mesh)).first->second;
    sum += triangles * CountInstances(root, node->node);
    if (sum > haptics::kMaxTriangles) {
      throw LoadError(node->pointer, "with those before, has more than " + std::to_string(haptics::kMaxTriangles) +
                                         " triangles; simplify the model or tag only what is touched");
    }
  }
}

}  // namespace omni::scene
