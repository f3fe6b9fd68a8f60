// A triangle mesh while it is being made fit for the tick; set-up only.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "service/haptics/geometry/vec_math.h"

namespace omni::haptics {

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> material;                   // per triangle
  std::vector<std::array<std::uint32_t, 3>> neighbours;  // per triangle, across edge k -> k + 1
  std::vector<std::uint32_t> component;                  // per triangle
};

}  // namespace omni::haptics
