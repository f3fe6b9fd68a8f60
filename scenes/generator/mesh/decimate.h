// Fewer triangles, same shape.
#pragma once

#include <cstddef>
#include <vector>

#include "scenes/generator/mesh/mesh.h"

namespace omni::scenes {

// Edge collapses in the order of their quadric error [Garland & Heckbert 1997] until `triangles` are left. `importance`
// (one per vertex, 1 = plain) multiplies the error: detail stays where it is high. A closed manifold stays one.
Mesh Decimate(const Mesh& mesh, const std::vector<double>& importance, std::size_t triangles);

}  // namespace omni::scenes
