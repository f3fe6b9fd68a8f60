// A tetrahedral lattice that fills a triangle mesh, by isosurface stuffing [Labelle & Shewchuk 2007]: a body-centred
// cubic (BCC) grid, warped and cut where the winding number passes one half. BCC rather than cubes cut in six (Kuhn),
// because its stiffness has no favourite diagonal; cut rather than merely embedding, because contact happens at the
// surface, and half-filled cells would make it too stiff there. The mesh is only asked "inside or outside", so that its
// defects cannot stop the build. Set-up only. docs/theory/deformable.md, section 1.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

struct TetLattice {
  std::vector<Vec3> vertices_base_m;
  std::vector<std::array<std::uint32_t, 4>> tets;     // positive volume
  std::vector<std::array<std::uint32_t, 3>> surface;  // outwards; corners lie on the mesh
  double cell_m = 0;                                  // edge of a BCC cube; node spacing is about 0.9 of it
};

struct LatticeOptions {
  std::uint32_t max_tets = 4000;              // [100, 400000]
  std::uint32_t max_surface_vertices = 1000;  // [50, 1024]
  Vec3 shift_cells{0.137, 0.291, 0.419};      // of the grid, so that flat faces do not fall on grid planes
};

// The finest lattice within both limits. Of parts connected only by an edge or a vertex, all but the largest are
// dropped. Fails if nothing is inside (open sheet, zero thickness), a coordinate is not a number, or `progress`, called
// with the share done in [0, 1] before each trial (0.1 s), returns false ("cancelled").
base::Result<TetLattice> BuildTetLattice(std::span<const Vec3> vertices_base_m,
                                         std::span<const std::array<std::uint32_t, 3>> triangles,
                                         const LatticeOptions& options = {},
                                         const std::function<bool(double)>& progress = {});

// One lattice of the given cell; `lattice.tets` is empty if nothing is inside.
TetLattice StuffLattice(std::span<const Vec3> vertices_base_m, std::span<const std::array<std::uint32_t, 3>> triangles,
                        double cell_m, const Vec3& shift_cells);

double TetVolume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

using TetCorners = std::array<std::uint32_t, 4>;

// Cuts one tetrahedron of the lattice by the surface. Pieces are split by vertex number, so that neighbours agree on
// the diagonals of what they share [Dompierre et al. 1999]. Appends the inside part of `tet` to `pieces` (orientation
// left open). `side[k]`: +1 inside, 0 on the surface, -1 outside; `cut(inside, outside)` gives the vertex where that
// edge is cut.
void CutTet(const TetCorners& tet, const std::array<int, 4>& side,
            const std::function<std::uint32_t(std::uint32_t, std::uint32_t)>& cut, std::vector<TetCorners>& pieces);

// Keeps a mesh's sharp edges in the lattice that was cut from it. A cut grid rounds them by up to half a cell, and a
// body that lacks its rim is too soft beside it.
// Moves corners of the lattice's surface onto sharp edges nearby (faces more than 30 degrees apart), the nearest first,
// where no tetrahedron becomes worse than a sliver. They stay on the mesh. Edges without exactly two triangles are
// ignored.
void KeepSharpEdges(std::span<const Vec3> vertices_base_m, std::span<const std::array<std::uint32_t, 3>> triangles,
                    TetLattice& lattice);

}  // namespace omni::haptics
