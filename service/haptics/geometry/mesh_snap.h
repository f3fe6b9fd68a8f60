// T-junctions: a vertex of one triangle on the edge of another leaves a crack without width, across which the two are
// not neighbours. The edge is split at the vertex. docs/theory/haptics.md (R.2). Set-up only.
#pragma once

#include "service/haptics/geometry/mesh.h"
#include "service/haptics/geometry/mesh_edges.h"

namespace omni::haptics {

inline constexpr double kSnapRelative = 1e-6;  // distance of vertex and edge, of the mesh's largest extent

// Splits each border edge at the border vertices on it; one edge of a triangle at a time, so call it again until it
// gives 0. Neighbours are not up to date afterwards. Returns the number of vertices that split an edge.
std::uint32_t SnapTJunctions(Mesh& mesh, const EdgeList& edges);

}  // namespace omni::haptics
