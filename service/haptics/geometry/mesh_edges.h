// Edges of a mesh in a sorted list: pairs of neighbours, borders, and whether two vertices share an edge. Set-up only.
#pragma once

#include <cstdint>
#include <vector>

#include "service/haptics/geometry/mesh.h"

namespace omni::haptics {

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
EdgeList ConnectEdges(Mesh& mesh);

}  // namespace omni::haptics
