// The node hierarchy of the scene that is shown: transforms by GLM, tags inherited from ancestors.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/scene/gltf/json_reading.h"
#include "service/scene/scene_file.h"
#include "service/scene/tags/haptic_tag.h"

namespace omni::scene {

struct NodeVisit {
  std::uint32_t node = 0;
  std::string pointer;  // /nodes/3
  std::string name;
  glm::dmat4 world{1.0};                       // node -> scene, whose y axis is up
  std::shared_ptr<const HapticTag> own;        // of this node alone; nullptr: it has none
  std::shared_ptr<const HapticTag> inherited;  // of its ancestors and itself, the nearest wins; never nullptr
  std::optional<std::uint32_t> mesh, skin;
  bool hidden = false;  // KHR_node_visibility: it or an ancestor is not visible
};

// Nodes reachable from the default scene (or from the roots, if there is none), parents first. Throws LoadError on a
// cycle, a node with two parents, bad indices, too many nodes or levels, transforms that are not finite.
// `named`: may be null.
std::vector<NodeVisit> WalkNodes(const Json& root, const LoadOptions& options, Warnings& warnings,
                                 const NamedTags* named = nullptr);

}  // namespace omni::scene
