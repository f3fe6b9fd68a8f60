// A glTF file as it looks, for pictures: every triangle of the scene that is shown, with its colour. Haptics reads
// files through scene_file.h.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::scene {

// One primitive of one node.
struct DrawnPart {
  std::string name;  // of the node
  std::vector<base::Vec3> positions_base_m;
  std::vector<base::Vec3> normals_base;  // unit; of the triangle, doubled vertices and all, where the file has none
  std::vector<base::Vec3> colours;       // linear RGB in [0, 1]: the material's times the vertex's
  std::vector<std::array<std::uint32_t, 3>> triangles;
  double roughness = 0.7;
};

struct DrawnScene {
  std::vector<DrawnPart> parts;    // at least one, none without triangles
  std::vector<std::string> notes;  // "<file>: <JSON pointer>: what is not drawn, or not as it would be elsewhere"
};

// `z_up`: as LoadOptions'. Errors: "<file>: <JSON pointer>: what, limit, what to do".
base::Result<DrawnScene> LoadDrawnScene(const std::string& path, bool z_up = false);

}  // namespace omni::scene
