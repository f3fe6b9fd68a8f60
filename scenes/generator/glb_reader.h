// Reads the .glb files that WriteGlb and `omni` write, for pictures: float positions, triangles, colours, node
// transforms.
#pragma once

#include <string>
#include <vector>

#include "scenes/generator/mesh.h"

namespace omni::scenes {

struct DrawnMesh {
  std::string name;
  Mesh mesh;  // base frame, colours per vertex
  std::vector<Vec> normals;
  double roughness = 0.7;
  bool overlay = false;  // seen through everything, casts and takes no shadow
};

// One per primitive. Throws std::runtime_error.
std::vector<DrawnMesh> ReadGlb(const std::string& path);

}  // namespace omni::scenes
