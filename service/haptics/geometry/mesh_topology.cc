#include <algorithm>

#include "service/haptics/geometry/mesh_repair.h"
#include "service/haptics/geometry/mesh_steps.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

bool EdgeList::Has(std::uint32_t a, std::uint32_t b) const {
  const std::uint64_t key = EdgeKey(a, b);
  const auto found = std::lower_bound(edges.begin(), edges.end(), key,
                                      [](const HalfEdge& edge, std::uint64_t wanted) { return edge.key < wanted; });
  return found != edges.end() && found->key == key;
}

EdgeList ConnectEdges(Mesh& mesh, const base::WorkWatch& watch) {
  EdgeList list;
  const std::size_t n = mesh.triangles.size();
  mesh.neighbours.assign(n, {kNoIndex, kNoIndex, kNoIndex});
  std::vector<HalfEdge>& edges = list.edges;
  // By their smaller vertex first: what is left to sort are the few edges of each vertex.
  std::vector<std::uint32_t> end(mesh.vertices.size() + 1, 0);
  const auto smaller = [&](std::uint32_t t, std::uint32_t k) {
    return std::min(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
  };
  for (std::uint32_t t = 0; t < n; ++t) {
    watch.Did();
    for (std::uint32_t k = 0; k < 3; ++k) ++end[smaller(t, k) + 1];
  }
  for (std::size_t v = 1; v < end.size(); ++v) end[v] += end[v - 1];
  edges.resize(3 * n);
  for (std::uint32_t t = 0; t < n; ++t) {
    watch.Did();
    for (std::uint32_t k = 0; k < 3; ++k)
      edges[end[smaller(t, k)]++] = {EdgeKey(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]), t, k};
  }
  for (std::size_t v = 0, first = 0; v + 1 < end.size(); first = end[v++]) {
    std::sort(edges.begin() + static_cast<std::ptrdiff_t>(first), edges.begin() + end[v],
              [&](const HalfEdge& x, const HalfEdge& y) {
                watch.Did();
                return x.key != y.key ? x.key < y.key : x.triangle < y.triangle;
              });
  }
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t next = i + 1;
    while (next < edges.size() && edges[next].key == edges[i].key) ++next;
    if (next - i == 2) {
      mesh.neighbours[edges[i].triangle][edges[i].edge] = edges[i + 1].triangle;
      mesh.neighbours[edges[i + 1].triangle][edges[i + 1].edge] = edges[i].triangle;
    }
    if (next - i == 1) list.borders.push_back(edges[i]);
    list.non_manifold += next - i > 2;
    i = next;
  }
  return list;
}

namespace {

std::uint32_t EdgeTo(const Mesh& mesh, std::uint32_t triangle, std::uint32_t a, std::uint32_t b) {
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t x = mesh.triangles[triangle][k], y = mesh.triangles[triangle][(k + 1) % 3];
    if ((x == a && y == b) || (x == b && y == a)) return k;
  }
  return 3;
}

// Breadth first from each unvisited triangle: two neighbours agree if they run through their edge in opposite
// directions.
void OrientComponents(Mesh& mesh, TopologyReport& report, const base::WorkWatch& watch) {
  const std::size_t n = mesh.triangles.size();
  mesh.component.assign(n, kNoIndex);
  std::vector<std::uint32_t> queue;
  queue.reserve(n);
  for (std::uint32_t seed = 0; seed < n; ++seed) {
    if (mesh.component[seed] != kNoIndex) continue;
    const std::uint32_t component = report.components++;
    mesh.component[seed] = component;
    queue.assign(1, seed);
    for (std::size_t head = 0; head < queue.size(); ++head) {
      watch.Did();
      const std::uint32_t t = queue[head];
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t other = mesh.neighbours[t][k];
        if (other == kNoIndex) continue;
        const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
        const std::uint32_t back = EdgeTo(mesh, other, a, b);
        const bool agrees = mesh.triangles[other][back] == b;
        if (mesh.component[other] == kNoIndex) {
          mesh.component[other] = component;
          queue.push_back(other);
          if (!agrees) {
            Flip(mesh, other);
            ++report.flipped_triangles;
          }
        } else if (!agrees) {
          mesh.neighbours[t][k] = kNoIndex;
          mesh.neighbours[other][back] = kNoIndex;
          ++report.cut_edges;
        }
      }
    }
  }
}

}  // namespace

TopologyReport ConnectAndOrient(Mesh& mesh, const base::WorkWatch& watch) {
  TopologyReport report;
  if (mesh.triangles.empty()) return report;
  EdgeList edges = ConnectEdges(mesh, watch);
  const std::size_t most = MostTriangles(mesh.triangles.size());
  const StitchReport stitched = StitchCracks(mesh, edges, watch);
  const SnapReport snapped = SnapTJunctions(mesh, edges, most, watch);
  report.snapped = snapped.split;
  report.unsnapped = snapped.unsearched;
  report.stitched = stitched.welded;
  report.stitched_within_m = stitched.within_m;
  OrientComponents(mesh, report, watch);
  report.closed_holes = CloseSmallHoles(mesh, edges, report.components, most, watch);
  if (report.closed_holes > 0) {
    const TopologyReport before = report;
    edges = {};
    edges = ConnectEdges(mesh, watch);
    report.components = report.cut_edges = 0;
    OrientComponents(mesh, report, watch);
    report.flipped_triangles = before.flipped_triangles;  // the first time turned all there was to turn
  }
  report.border_edges = static_cast<std::uint32_t>(edges.borders.size());
  report.non_manifold_edges = edges.non_manifold;
  edges = {};
  const OrientReport oriented = OrientOutwards(mesh, report.components, watch);
  report.flipped_components = oriented.flipped;
  report.cavities = oriented.cavities;
  report.by_volume = oriented.by_volume;
  report.solidity = oriented.solidity;
  return report;
}

}  // namespace omni::haptics
