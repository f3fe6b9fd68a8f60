// A service's whole messages about an application's scene.
#pragma once

#include <string>
#include <vector>

#include "service/protocol/haptic_scene.h"

namespace omni::test {

struct SceneTable {
  std::vector<protocol::HapticNodeRow> nodes;
  std::vector<base::MaterialParameters> materials;
};

// Two nodes: 0 is soft and stays where it is, 1 can be moved and is 0.1 m to the right and 0.3 m up in the document.
// One material.
SceneTable TwoNodes();
// That many movable nodes and materials.
SceneTable ManyNodes(std::size_t nodes, std::size_t materials);

std::string SceneTableMessage(std::uint32_t number, const SceneTable& table);
std::string SceneStateMessage(std::uint32_t number, protocol::HapticSceneStatus status, std::uint64_t generation,
                              const std::string& text, double scale = 1);

}  // namespace omni::test
