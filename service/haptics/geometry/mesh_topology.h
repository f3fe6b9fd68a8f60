// Second repair step: who is whose neighbour, one orientation per component, closed components outwards.
#pragma once

#include "service/haptics/geometry/mesh.h"

namespace omni::haptics {

struct TopologyReport {
  std::uint32_t components = 0;
  std::uint32_t border_edges = 0;        // used by one triangle
  std::uint32_t non_manifold_edges = 0;  // used by three or more
  std::uint32_t cut_edges = 0;           // no consistent orientation exists across them (Moebius strip)
  std::uint32_t flipped_triangles = 0;   // to agree with the rest of their component
  std::uint32_t flipped_components = 0;  // inside-out as a whole
  std::uint32_t cavities = 0;            // closed, inwards, inside another component: left so
  bool Closed() const { return border_edges == 0 && non_manifold_edges == 0 && cut_edges == 0; }
};

// Fills mesh.neighbours and mesh.component, reorders corners where a triangle has to be turned.
TopologyReport ConnectAndOrient(Mesh& mesh);

}  // namespace omni::haptics
