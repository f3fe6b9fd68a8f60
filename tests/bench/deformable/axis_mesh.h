// The reference's bodies as triangle meshes, for the methods under test.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "service/base/vec.h"
#include "tests/bench/deformable/axisymmetric.h"

namespace omni::bench {

struct SurfaceMesh {
  std::vector<base::Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Turned about z, base at z = 0, closed.
SurfaceMesh TurnBody(const AxisBody& body, int around, int rings);

}  // namespace omni::bench
