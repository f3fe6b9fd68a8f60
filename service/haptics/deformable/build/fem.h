// Linear finite elements on a tetrahedral lattice: straight-edged ten-node tetrahedra (linear ones lock when nearly
// incompressible and are several times stiffer at equal cost), a clamped set of nodes, and one factorisation for
// many loads. docs/theory/deformable.md, section 3. Set-up only.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "service/base/result.h"
#include "service/haptics/deformable/build/elasticity.h"
#include "service/haptics/deformable/build/lattice.h"

namespace omni::haptics {

// Nodes: the lattice's vertices, then one in the middle of each edge.
struct QuadraticMesh {
  std::vector<Vec3> nodes_base_m;
  std::vector<std::array<std::uint32_t, 10>> tets;    // corners, then edges 01 12 02 03 13 23
  std::vector<std::array<std::uint32_t, 6>> surface;  // corners, then edges 01 12 20; outwards
};

QuadraticMesh MakeQuadratic(const TetLattice& lattice);

// 30 x 30, row-major, degree of freedom 3 node + axis, N/m.   (3.1)
std::array<double, 900> ElementStiffness(const std::array<Vec3, 4>& corners, const Stiffness6& stiffness);

inline constexpr std::size_t kSolveWidth = 8;  // loads solved together
// Row 3 node + axis, one column per load.
using LoadBlock = std::vector<std::array<double, kSolveWidth>>;

class ElasticFem {
 public:
  // `stiffness(p)`: of the material at p. Fails if nothing is clamped, all is, or the matrix is singular. `go_on` is
  // called now and then with 0 ... 1; false: stop, with the error "cancelled".
  static base::Result<ElasticFem> Build(const QuadraticMesh& mesh,
                                        const std::function<Stiffness6(const Vec3&)>& stiffness,
                                        const std::vector<bool>& clamped,
                                        const std::function<bool(double done)>& go_on = {});
  ElasticFem(ElasticFem&&) noexcept;
  ElasticFem& operator=(ElasticFem&&) noexcept;
  ~ElasticFem();

  // Forces in (N), displacements out (m); clamped nodes give 0.   K u = f
  void Solve(LoadBlock& block) const;
  std::size_t factor_entries() const;

 private:
  struct Factor;
  explicit ElasticFem(std::unique_ptr<Factor> factor);
  std::unique_ptr<Factor> factor_;
};

// A Hertz pressure spread over the surface around a node (patch_load.cc): what a column of the compliance answers to. A
// point load would make the node's own compliance depend on the mesh; a patch of several node spacings does not, and
// that of a half-space is known in closed form. Section 4.

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
