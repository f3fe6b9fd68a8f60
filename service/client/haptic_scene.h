// What omnid reports about an application's own scene (protocol/haptic_scene.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/protocol/haptic_scene.h"

namespace omni::client {

struct HapticSceneTable {
  std::uint32_t number = 0;
  std::vector<protocol::HapticNodeRow> nodes;  // row i is object i
  std::vector<base::MaterialParameters> materials;
};

// Either a state with its text, or a table.
struct HapticSceneUpdate {
  bool is_table = false;
  protocol::HapticSceneState state;
  std::string text;
  HapticSceneTable table;
};

}  // namespace omni::client
