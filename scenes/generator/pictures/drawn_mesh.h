// What pictures are made of.
#pragma once

#include <string>
#include <vector>

#include "scenes/generator/mesh/mesh.h"

namespace omni::scenes {

struct DrawnMesh {
  std::string name;
  Mesh mesh;  // base frame, colours per vertex
  std::vector<Vec> normals;
  double roughness = 0.7;
  bool overlay = false;  // seen through everything, casts and takes no shadow
};

// What a scene looks like, one mesh per primitive of each node, by the service's own reader
// (service/scene/drawn_scene.h). What is not drawn is reported on stderr. Throws std::runtime_error.
std::vector<DrawnMesh> ReadMeshes(const std::string& path);

}  // namespace omni::scenes
