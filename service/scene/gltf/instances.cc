#include "service/scene/gltf/instances.h"

#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>

#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/load_error.h"

namespace omni::scene {

bool IsInstanced(const Json& root, std::uint32_t node) {
  const Json* extensions = Find(ElementOf(root, "nodes", node), "extensions");
  return extensions && Find(*extensions, kInstancingExtension);
}

std::uint64_t CountInstances(const Json& root, std::uint32_t node) {
  const std::string pointer = Join("/nodes", node);
  const Json* extensions = FindObject(ElementOf(root, "nodes", node), pointer, "extensions");
  const std::string place = Join(Join(pointer, "extensions"), kInstancingExtension);
  const Json* json = extensions ? FindObject(*extensions, Join(pointer, "extensions"), kInstancingExtension) : nullptr;
  if (!json) return 1;
  const Json* attributes = FindObject(*json, place, "attributes");
  std::optional<std::uint64_t> count;
  for (const char* name : {"TRANSLATION", "ROTATION", "SCALE"}) {
    const auto accessor =
        attributes ? Index(*attributes, Join(place, "attributes"), name, CountOf(root, "accessors")) : std::nullopt;
    if (!accessor) continue;
    const std::uint64_t own = Whole(ElementOf(root, "accessors", *accessor), Join("/accessors", *accessor), "count",
                                    haptics::kMaxTriangles, std::nullopt);
    if (count && own != *count) throw LoadError(place, "has attributes of different counts; they must be equal");
    count = own;
  }
  if (!count) throw LoadError(place, "has none of TRANSLATION, ROTATION and SCALE");
  return *count;
}

// X = T R S of each   [EXT_mesh_gpu_instancing]
std::vector<glm::dmat4> PlacesOf(const NodeVisit& node, const std::vector<Instance>& instances) {
  std::vector<glm::dmat4> places;
  for (const auto& [t, q, s] : instances) {
    glm::dmat4 X(1.0);
    const glm::dquat turn(q[3], q[0], q[1], q[2]);
    if (!(glm::length(turn) > 1e-6))
      throw LoadError(node.pointer, "instance " + std::to_string(places.size()) + " has a rotation of zero");
    X[3] = glm::dvec4(t[0], t[1], t[2], 1);
    X = X * glm::mat4_cast(turn / glm::length(turn));
    for (int k = 0; k < 3; ++k) X[k] *= s[static_cast<std::size_t>(k)];
    places.push_back(node.world * X);
  }
  return places;
}

}  // namespace omni::scene
