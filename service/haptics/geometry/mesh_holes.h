// Small holes of a body that is otherwise closed. docs/theory/haptics.md (R.3). Set-up only.
#pragma once

#include "service/haptics/geometry/mesh.h"
#include "service/haptics/geometry/mesh_edges.h"

namespace omni::haptics {

inline constexpr std::size_t kMaxHoleEdges = 64;
inline constexpr double kMaxHoleRelative = 0.2;  // the hole's diagonal, of its component's
inline constexpr std::size_t kMaxHoles = 1000;   // of a mesh

// Fills the holes of every component that has only small ones: then it is closed, and the tip can be inside. Sheets
// keep theirs. Each hole gets the triangulation of least area [Barequet & Sharir 1995]. Precondition: neighbours and
// components are filled, each component oriented in itself. Neighbours are not up to date afterwards. Returns the
// number of holes that were filled.
std::uint32_t CloseSmallHoles(Mesh& mesh, const EdgeList& edges, std::uint32_t components);

}  // namespace omni::haptics
