// A Hertz pressure spread over the surface around a node: what a column of the compliance answers to. A point load
// would make the node's own compliance depend on the mesh; a patch of several node spacings does not, and that of a
// half-space is known in closed form. docs/theory/deformable.md, section 4. Set-up only.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "service/haptics/deformable/build/fem.h"

namespace omni::haptics {

// Consistent nodal shares, sum 1, of a force along -normal.
struct PatchLoad {
  Vec3 normal;  // unit, outwards
  std::vector<std::pair<std::uint32_t, double>> shares;
};

// Position of a node and shape of its surroundings.
struct SurfacePatch {
  Vec3 point_base_m;
  Vec3 normal;               // unit, outwards, area-weighted over the triangles of the node
  double curvature_1_m = 0;  // mean of the two principal ones, convex > 0, at the scale of the patch
};

// p = 3 / (2 pi a^2) sqrt(1 - r^2 / a^2), r across the normal, on triangles that face the same way.
PatchLoad SpreadLoad(const QuadraticMesh& mesh, const SurfacePatch& at, double radius_m);

// One patch per vertex of `nodes`.
std::vector<SurfacePatch> MeasurePatches(const QuadraticMesh& mesh, const std::vector<std::uint32_t>& nodes,
                                         double radius_m);

}  // namespace omni::haptics
