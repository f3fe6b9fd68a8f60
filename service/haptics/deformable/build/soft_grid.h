// The coarse surface's neighbours, its seed grid, and what hangs on it. Set-up only.
#pragma once

#include <array>
#include <vector>

#include "service/haptics/deformable/soft_body.h"

namespace omni::haptics {

// Fills in neighbours; across an edge of more than two triangles, one of the others.
void ConnectSoftTriangles(std::vector<SoftTriangle>& triangles);

struct SoftGridResult {
  std::array<std::uint32_t, 3> count{};
  Vec3 lower_m;
  double cell_m = 0;
  std::vector<std::uint32_t> seed;  // nearest triangle of every cell's centre, x fastest
};

// At most 20 cells along the longest side.
SoftGridResult MakeSoftGrid(const std::vector<SoftNode>& nodes, const std::vector<SoftTriangle>& triangles,
                            double lattice_cell_m);

// Nearest place among all triangles.
SoftSkin HangOnSurface(const std::vector<SoftNode>& nodes, const std::vector<SoftTriangle>& triangles,
                       const SoftGridResult& grid, const Vec3& point_base_m);

}  // namespace omni::haptics
