// Zero set of a field -> closed triangle mesh.
#pragma once

#include <span>

#include "scenes/generator/mesh/mesh.h"
#include "scenes/generator/mesh/sdf.h"

namespace omni::scenes {

// Marching tetrahedra on a grid of `cell` mm over [lower, upper] (which must hold the solid), vertices then moved onto
// the zero set. Closed and manifold by construction. Result in millimetres.
Mesh Polygonise(std::span<const Shape> shapes, const Vec& lower, const Vec& upper, double cell);

}  // namespace omni::scenes
