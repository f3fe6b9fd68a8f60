// Makes a mesh fit for the tick, in two steps. RepairMesh: one vertex per place, only triangles with area, none twice.
// ConnectAndOrient (mesh_topology.cc): finds neighbours, closes cracks and small holes, orients each component
// consistently and outwards. docs/theory/haptics.md (R.1) to (R.6). Set-up only.
#pragma once

#include <algorithm>
#include <cstddef>

#include "service/base/work_watch.h"
#include "service/haptics/geometry/mesh.h"
#include "service/haptics/scene/material.h"
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
Mesh RepairMesh(const InputObject& input, RepairCounts& counts, const base::WorkWatch& watch = {});

// Splitting edges and closing holes make at most so many triangles of `triangles`.
constexpr std::size_t MostTriangles(std::size_t triangles) {
  return std::min<std::size_t>(triangles + triangles / 8 + 1000, kMaxTriangles);
}

struct TopologyReport {
  std::uint32_t components = 0;
  std::uint32_t border_edges = 0;        // used by one triangle
  std::uint32_t non_manifold_edges = 0;  // used by three or more
  std::uint32_t cut_edges = 0;           // no consistent orientation exists across them (Moebius strip)
  std::uint32_t snapped = 0;             // edges split at a vertex that lay on them (T-junctions)
  std::uint32_t unsnapped = 0;           // edges on which vertices were not searched, or not split at: too many
  std::uint32_t stitched = 0;            // vertices of borders, welded over cracks ...
  double stitched_within_m = 0;          // ... with this tolerance
  std::uint32_t closed_holes = 0;        // small ones
  std::uint32_t flipped_triangles = 0;   // to agree with the rest of their component
  std::uint32_t flipped_components = 0;  // inside-out as a whole
  std::uint32_t cavities = 0;            // closed, inwards, inside another component: left so
  std::uint32_t by_volume = 0;           // components turned by their own volumes: to ask more would take too long
  double solidity = 0;  // mean winding number on parts that are open: 1/2 on walls of solids, 0 on sheets
  bool IsClosed() const { return border_edges == 0 && non_manifold_edges == 0 && cut_edges == 0; }
};

// Fills mesh.neighbours and mesh.component, reorders corners where a triangle has to be turned, adds triangles at
// cracks and small holes.
TopologyReport ConnectAndOrient(Mesh& mesh, const base::WorkWatch& watch = {});

}  // namespace omni::haptics
