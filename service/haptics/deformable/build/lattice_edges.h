// Keeps a mesh's sharp edges in the lattice that was cut from it. A cut grid rounds them by up to half a cell, and a
// body that lacks its rim is too soft beside it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "service/haptics/deformable/build/lattice.h"

namespace omni::haptics {

// Moves corners of the lattice's surface onto sharp edges nearby (faces more than 30 degrees apart), the nearest first,
// where no tetrahedron becomes worse than a sliver. They stay on the mesh. Edges without exactly two triangles are
// ignored.
void KeepSharpEdges(std::span<const Vec3> vertices_base_m, std::span<const std::array<std::uint32_t, 3>> triangles,
                    TetLattice& lattice);

}  // namespace omni::haptics
