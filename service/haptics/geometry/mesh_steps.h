// The steps of ConnectAndOrient (mesh_repair.h): edges, cracks, small holes, orientation. Set-up only.
#pragma once

#include <cstdint>
#include <vector>

#include "service/base/work_watch.h"
#include "service/haptics/geometry/mesh.h"

namespace omni::haptics {

// Edges of a mesh in a sorted list: pairs of neighbours, borders, and whether two vertices share an edge.
struct HalfEdge {
  std::uint64_t key;  // smaller vertex, larger vertex
  std::uint32_t triangle;
  std::uint32_t edge;
};

inline std::uint64_t EdgeKey(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
}

struct EdgeList {
  std::vector<HalfEdge> edges;     // sorted by key, then triangle
  std::vector<HalfEdge> borders;   // used by one triangle
  std::uint32_t non_manifold = 0;  // edges of three and more triangles

  bool Has(std::uint32_t a, std::uint32_t b) const;
};

// Lists the edges and fills mesh.neighbours: edges of one or of three and more triangles stay without neighbour.
EdgeList ConnectEdges(Mesh& mesh, const base::WorkWatch& watch);

// Cracks: the two sides of an edge were rounded differently, and lie closer together than can be felt. Their
// vertices become one, the nearest first: with a tolerance that grows until the mesh is closed (mesh_repair.cc) (R.2).
inline constexpr double kStitch_m[] = {1e-7, 1e-6, 1e-5};
inline constexpr double kStitched = 0.5;  // where more of the border is left, these were no cracks: all stays as it was

struct StitchReport {
  std::uint32_t welded = 0;  // vertices of the border
  double within_m = 0;       // the last tolerance that welded any
};

// Edges and neighbours are up to date afterwards. A mesh without a border costs nothing.
StitchReport StitchCracks(Mesh& mesh, EdgeList& edges, const base::WorkWatch& watch);

// T-junctions: a vertex of one triangle on the edge of another leaves a crack without width, across which the two are
// not neighbours. The edge is split at the vertex (mesh_snap.cc)   (R.2).
inline constexpr double kSnapRelative = 1e-6;  // distance of vertex and edge, of the mesh's largest extent

struct SnapReport {
  std::uint32_t split = 0;       // at so many vertices
  std::uint32_t unsearched = 0;  // edges that were left, because it would take too long
};

// Splits each border edge at the border vertices on it, one edge of a triangle at a time, until there is none left:
// then edges and neighbours are up to date again. The mesh gets at most `most` triangles.
SnapReport SnapTJunctions(Mesh& mesh, EdgeList& edges, std::size_t most, const base::WorkWatch& watch);

// Small holes of a body (mesh_holes.cc)   (R.3).
inline constexpr std::size_t kMaxHoleEdges = 256;
inline constexpr double kMaxHoleRelative = 0.2;  // the hole's diagonal, of its component's
inline constexpr std::size_t kMaxHoles = 1000;   // of a mesh

inline constexpr double kMostOpen = 0.25;  // of a body: |sum of area vectors| over the area; 0: closed, 1: flat

// Fills holes one by one, the smallest first: those of components that have only small ones, and small ones of bodies
// that stay open otherwise. Sheets keep theirs. Each hole gets the triangulation of least area [Barequet & Sharir
// 1995]. Precondition: neighbours and components are filled, each component oriented in itself. Neighbours are not up
// to date afterwards. Returns the number of holes that were filled. The mesh gets at most `most` triangles.
std::uint32_t CloseSmallHoles(Mesh& mesh, const EdgeList& edges, std::uint32_t components, std::size_t most,
                              const base::WorkWatch& watch);

// Each component's front faces out of the body (mesh_orient.cc)   (R.6).
struct OrientReport {
  std::uint32_t flipped = 0;   // components that were inside-out
  std::uint32_t cavities = 0;  // closed, inwards, inside another component: left so
  double solidity = 0;         // mean winding number on parts that are open: 1/2 of a solid, 0 of a sheet; 0: not asked
  std::uint32_t by_volume = 0;  // not asked, because it would take too long: turned by the sign of their own volumes
};

// Precondition: mesh.component is filled with numbers below `components`, each component is oriented in itself.
OrientReport OrientOutwards(Mesh& mesh, std::uint32_t components, const base::WorkWatch& watch);

}  // namespace omni::haptics
