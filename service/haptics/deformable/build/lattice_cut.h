// Cutting one tetrahedron of the lattice by the surface. Pieces are split by vertex number, so that neighbours agree on
// the diagonals of what they share [Dompierre et al. 1999]. Set-up only.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace omni::haptics {

using TetCorners = std::array<std::uint32_t, 4>;

// Appends the inside part of `tet` to `pieces` (orientation left open). `side[k]`: +1 inside, 0 on the surface, -1
// outside; `cut(inside, outside)` gives the vertex where that edge is cut.
void CutTet(const TetCorners& tet, const std::array<int, 4>& side,
            const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& cut, std::vector<TetCorners>& pieces);

}  // namespace omni::haptics
