// First repair step: one vertex per place, only triangles with area, none twice.
#pragma once

#include "service/haptics/geometry/mesh.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::haptics {

struct RepairCounts {
  std::uint32_t welded_vertices = 0;
  std::uint32_t not_finite = 0;  // triangles dropped
  std::uint32_t degenerate = 0;
  std::uint32_t duplicate = 0;
};

inline constexpr double kWeldRelative = 1e-7;  // of the object's largest extent

// Precondition: indices and materials of `input` are in range. Triangles at non-finite vertices are dropped.
Mesh RepairMesh(const InputObject& input, RepairCounts& counts);

}  // namespace omni::haptics
