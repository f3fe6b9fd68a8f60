#include "service/haptics/geometry/mesh_edges.h"

#include <algorithm>

#include "service/haptics/scene/scene.h"

namespace omni::haptics {

bool EdgeList::Has(std::uint32_t a, std::uint32_t b) const {
  const std::uint64_t key = EdgeKey(a, b);
  const auto found = std::lower_bound(edges.begin(), edges.end(), key,
                                      [](const HalfEdge& edge, std::uint64_t wanted) { return edge.key < wanted; });
  return found != edges.end() && found->key == key;
}

EdgeList ConnectEdges(Mesh& mesh) {
  EdgeList list;
  const std::size_t n = mesh.triangles.size();
  mesh.neighbours.assign(n, {kNoIndex, kNoIndex, kNoIndex});
  std::vector<HalfEdge>& edges = list.edges;
  edges.reserve(3 * n);
  for (std::uint32_t t = 0; t < n; ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      edges.push_back({EdgeKey(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]), t, k});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& x, const HalfEdge& y) {
    return x.key != y.key ? x.key < y.key : x.triangle < y.triangle;
  });
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].key == edges[i].key) ++end;
    if (end - i == 2) {
      mesh.neighbours[edges[i].triangle][edges[i].edge] = edges[i + 1].triangle;
      mesh.neighbours[edges[i + 1].triangle][edges[i + 1].edge] = edges[i].triangle;
    }
    if (end - i == 1) list.borders.push_back(edges[i]);
    list.non_manifold += end - i > 2;
    i = end;
  }
  return list;
}

}  // namespace omni::haptics
