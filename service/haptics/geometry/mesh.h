// A triangle mesh while it is being made fit for the tick; set-up only.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "service/base/vec.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::haptics {

using base::Vec3;

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> material;                   // per triangle
  std::array<std::vector<CornerUv>, kMaxUvSets> uv;      // per triangle; a set is empty if no texture needs it
  std::vector<std::array<std::uint32_t, 3>> neighbours;  // per triangle, across edge k -> k + 1
  std::vector<std::uint32_t> component;                  // per triangle
};

// (a, b, c) -> (a, c, b): edges 0 and 2 change places, edge 1 stays. Neighbours need not be there yet.
inline void Flip(Mesh& mesh, std::uint32_t t) {
  std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  if (!mesh.neighbours.empty()) std::swap(mesh.neighbours[t][0], mesh.neighbours[t][2]);
  for (std::vector<CornerUv>& set : mesh.uv) {
    if (set.empty()) continue;
    std::swap(set[t][2], set[t][4]);
    std::swap(set[t][3], set[t][5]);
  }
}

}  // namespace omni::haptics
