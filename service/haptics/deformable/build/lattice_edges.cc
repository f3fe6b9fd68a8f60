#include "service/haptics/deformable/build/lattice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace omni::haptics {
namespace {

constexpr double kSharpCosine = 0.866;  // of the angle between normals: 30 degrees
constexpr double kReach_cells = 0.6;    // nodes are about 0.9 cells apart
constexpr double kLeastShape = 0.006;   // volume over the longest edge cubed; a regular tetrahedron has 0.118
constexpr double kMostLost = 0.3;       // of a shape that was bad before

struct Segment {
  Vec3 from, to;
};

struct Snap {
  double distance_m;
  std::uint32_t vertex;
  Vec3 to;
};

// For each vertex the first one at the same place: edges of an unwelded mesh have two faces too.
std::vector<std::uint32_t> SamePlace(std::span<const Vec3> vertices) {
  std::map<std::array<double, 3>, std::uint32_t> first;
  std::vector<std::uint32_t> same;
  for (std::uint32_t v = 0; v < vertices.size(); ++v) {
    same.push_back(first.try_emplace({vertices[v].x, vertices[v].y, vertices[v].z}, v).first->second);
  }
  return same;
}

std::vector<Segment> SharpEdges(std::span<const Vec3> vertices,
                                std::span<const std::array<std::uint32_t, 3>> triangles) {
  struct Use {
    Vec3 normal;
    int count = 0;
    bool sharp = false;
  };
  const std::vector<std::uint32_t> same = SamePlace(vertices);
  std::map<std::pair<std::uint32_t, std::uint32_t>, Use> edges;
  for (const auto& t : triangles) {
    const Vec3 area = Cross(vertices[t[1]] - vertices[t[0]], vertices[t[2]] - vertices[t[0]]);
    if (!(Norm(area) > 0)) continue;
    const Vec3 normal = Normalized(area);
    for (std::size_t k = 0; k < 3; ++k) {
      Use& use = edges[std::minmax(same[t[k]], same[t[(k + 1) % 3]])];
      if (++use.count == 1) use.normal = normal;
      use.sharp = use.count == 2 && Dot(use.normal, normal) < kSharpCosine;
    }
  }
  std::vector<Segment> sharp;
  for (const auto& [ends, use] : edges) {
    if (use.sharp) sharp.push_back({vertices[ends.first], vertices[ends.second]});
  }
  return sharp;
}

Vec3 NearestOn(const Segment& segment, const Vec3& point) {
  const Vec3 along = segment.to - segment.from;
  const double squared = Dot(along, along);
  const double share = squared > 0 ? std::clamp(Dot(point - segment.from, along) / squared, 0.0, 1.0) : 0;
  return segment.from + share * along;
}

std::vector<Snap> FindSnaps(const std::vector<Segment>& edges, const TetLattice& lattice) {
  std::vector<bool> outside(lattice.vertices_base_m.size(), false);
  for (const auto& triangle : lattice.surface) {
    for (const std::uint32_t v : triangle) outside[v] = true;
  }
  std::vector<Snap> snaps;
  for (std::uint32_t v = 0; v < outside.size(); ++v) {
    if (!outside[v]) continue;
    Snap nearest{kReach_cells * lattice.cell_m, v, {}};
    bool found = false;
    for (const Segment& edge : edges) {
      const Vec3 to = NearestOn(edge, lattice.vertices_base_m[v]);
      const double distance_m = Norm(to - lattice.vertices_base_m[v]);
      if (!(distance_m < nearest.distance_m)) continue;
      nearest.distance_m = distance_m;
      nearest.to = to;
      found = true;
    }
    if (found) snaps.push_back(nearest);
  }
  std::sort(snaps.begin(), snaps.end(), [](const Snap& a, const Snap& b) {
    return std::pair(a.distance_m, a.vertex) < std::pair(b.distance_m, b.vertex);
  });
  return snaps;
}

double ShapeOf(const std::array<Vec3, 4>& p) {
  double longest_m = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) longest_m = std::max(longest_m, Norm(p[i] - p[j]));
  }
  return longest_m > 0 ? TetVolume(p[0], p[1], p[2], p[3]) / (longest_m * longest_m * longest_m) : 0;
}

std::array<Vec3, 4> CornersOf(const TetLattice& lattice, std::uint32_t tet) {
  std::array<Vec3, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) corners[k] = lattice.vertices_base_m[lattice.tets[tet][k]];
  return corners;
}

bool StaysGood(const TetLattice& lattice, std::uint32_t tet, std::uint32_t vertex, const Vec3& to) {
  std::array<Vec3, 4> corners = CornersOf(lattice, tet);
  const double before = ShapeOf(corners);
  for (std::size_t k = 0; k < 4; ++k) {
    if (lattice.tets[tet][k] == vertex) corners[k] = to;
  }
  return ShapeOf(corners) >= std::min(kLeastShape, (1 - kMostLost) * before);
}

}  // namespace

void KeepSharpEdges(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                    TetLattice& lattice) {
  const std::vector<Segment> edges = SharpEdges(vertices, triangles);
  if (edges.empty()) return;
  std::vector<std::vector<std::uint32_t>> tets_of(lattice.vertices_base_m.size());
  for (std::uint32_t t = 0; t < lattice.tets.size(); ++t) {
    for (const std::uint32_t v : lattice.tets[t]) tets_of[v].push_back(t);
  }
  for (const Snap& snap : FindSnaps(edges, lattice)) {
    const auto& around = tets_of[snap.vertex];
    const bool good = std::all_of(around.begin(), around.end(),
                                  [&](std::uint32_t tet) { return StaysGood(lattice, tet, snap.vertex, snap.to); });
    if (good) lattice.vertices_base_m[snap.vertex] = snap.to;
  }
}

}  // namespace omni::haptics
