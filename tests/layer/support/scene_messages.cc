#include "tests/layer/support/scene_messages.h"

#include <cstring>

namespace omni::test {
namespace {

template <class T>
void Append(std::string& message, const T& part) {
  message.append(reinterpret_cast<const char*>(&part), sizeof(part));
}

}  // namespace

SceneTable TwoNodes() {
  SceneTable table{std::vector<protocol::HapticNodeRow>(2), std::vector<base::MaterialParameters>(1)};
  std::strcpy(table.nodes[0].name, "still");
  table.nodes[0].gltf_node = 4;
  table.nodes[0].flags = protocol::kNodeSoft;
  std::strcpy(table.nodes[1].name, "moved");
  table.nodes[1].gltf_node = 2;
  table.nodes[1].flags = protocol::kNodeKinematic;
  table.nodes[1].rest_position_m = {0.1, 0.3, 0};
  table.materials[0].stiffness_N_m = 444;
  return table;
}

SceneTable ManyNodes(std::size_t nodes, std::size_t materials) {
  SceneTable table{std::vector<protocol::HapticNodeRow>(nodes), std::vector<base::MaterialParameters>(materials)};
  for (protocol::HapticNodeRow& row : table.nodes) row.flags = protocol::kNodeKinematic;
  return table;
}

std::string SceneTableMessage(std::uint32_t number, const SceneTable& table) {
  protocol::HapticSceneTable head;
  head.number = number;
  head.node_count = static_cast<std::uint32_t>(table.nodes.size());
  head.material_count = static_cast<std::uint32_t>(table.materials.size());
  std::string rows;
  for (const protocol::HapticNodeRow& row : table.nodes) Append(rows, row);
  for (const base::MaterialParameters& feel : table.materials) Append(rows, feel);
  head.header.size = static_cast<std::uint32_t>(sizeof(head) + rows.size());
  std::string message;
  Append(message, head);
  return message + rows;
}

std::string SceneStateMessage(std::uint32_t number, protocol::HapticSceneStatus status, std::uint64_t generation,
                              const std::string& text, double scale) {
  protocol::HapticSceneState state;
  state.number = number;
  state.status = status;
  state.generation = generation;
  state.scale = scale;
  state.load_ns = 5'000'000;
  state.triangle_count = 12;
  state.material_count = 1;
  state.header.size = static_cast<std::uint32_t>(sizeof(state) + text.size());
  std::string message;
  Append(message, state);
  return message + text;
}

}  // namespace omni::test
