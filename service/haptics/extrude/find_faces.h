// Finds the faces of an object that can be pushed and pulled: connected triangles of one extrudable material that face
// roughly the same way. Set-up only.
#pragma once

#include <vector>

#include "service/haptics/geometry/mesh.h"
#include "service/haptics/scene/material.h"

namespace omni::haptics {

struct Face {
  std::vector<std::uint32_t> triangles;
  Vec3 normal;  // area-weighted mean, unit
  Vec3 centroid_base_m;
  double area_m2 = 0;
  double radius_m = 0;
  std::uint32_t material = 0;
};

// Largest first. A material that wraps around an edge gives one face per side: a triangle joins if its normal is within
// about 35 degrees of the largest triangle's. Slivers under 5 % of the largest face stay rigid.
std::vector<Face> FindFaces(const Mesh& mesh, const std::vector<Material>& materials);

}  // namespace omni::haptics
