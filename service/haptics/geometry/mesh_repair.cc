#include "service/haptics/geometry/mesh_repair.h"

#include <algorithm>
#include <bit>

#include "service/base/free_memory.h"
#include "service/haptics/geometry/mesh_steps.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

std::uint64_t Mix(std::uint64_t h) {
  h ^= h >> 33;
  h *= 0xff51afd7ed558ccdULL;
  h ^= h >> 33;
  h *= 0xc4ceb9fe1a85ec53ULL;
  return h ^ (h >> 33);
}

std::uint64_t Hash3(std::uint64_t a, std::uint64_t b, std::uint64_t c) { return Mix(a + Mix(b + Mix(c))); }

bool IsFinite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Buckets of indices chained by `next`; a power of two of them.
class Buckets {
 public:
  explicit Buckets(std::size_t expected) : heads_(std::bit_ceil(expected + 1) * 2, kNoIndex) {}
  std::uint32_t& Head(std::uint64_t hash) { return heads_[hash & (heads_.size() - 1)]; }

 private:
  std::vector<std::uint32_t> heads_;
};

// Vertices within `tolerance_m` of an earlier kept one become that one. Cells are much larger than the tolerance, so
// that a vertex mostly needs its own cell only.
class Welder {
 public:
  Welder(double tolerance_m, std::size_t expected, const base::WorkWatch& watch)
      : tolerance_m_(tolerance_m), cell_m_(64 * tolerance_m), buckets_(expected), watch_(watch) {}

  // So many are kept at most: no block is larger than it must be.
  void Reserve(std::size_t most) {
    kept.reserve(most);
    next_.reserve(most);
  }

  std::uint32_t Add(const Vec3& p) {
    std::array<std::array<std::int64_t, 2>, 3> range{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double x = k == 0 ? p.x : (k == 1 ? p.y : p.z);
      range[k] = {Cell(x - tolerance_m_), Cell(x + tolerance_m_)};
    }
    for (std::int64_t i = range[0][0]; i <= range[0][1]; ++i) {
      for (std::int64_t j = range[1][0]; j <= range[1][1]; ++j) {
        for (std::int64_t k = range[2][0]; k <= range[2][1]; ++k) {
          const std::uint32_t found = FindIn(HashCell(i, j, k), p);
          if (found != kNoIndex) return found;
        }
      }
    }
    const auto index = static_cast<std::uint32_t>(kept.size());
    std::uint32_t& head = buckets_.Head(HashCell(Cell(p.x), Cell(p.y), Cell(p.z)));
    kept.push_back(p);
    next_.push_back(head);
    head = index;
    return index;
  }

  std::vector<Vec3> kept;

 private:
  static constexpr unsigned kMaxChain = 255;  // a crowd in one cell (one far outlier) must not make the build quadratic

  std::int64_t Cell(double x) const { return static_cast<std::int64_t>(std::floor(x / cell_m_)); }
  static std::uint64_t HashCell(std::int64_t i, std::int64_t j, std::int64_t k) {
    return Hash3(static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(j), static_cast<std::uint64_t>(k));
  }
  std::uint32_t FindIn(std::uint64_t hash, const Vec3& p) {
    std::uint32_t i = buckets_.Head(hash);
    unsigned passed = 0;
    while (i != kNoIndex && SquaredNorm(kept[i] - p) > tolerance_m_ * tolerance_m_) {
      i = ++passed < kMaxChain ? next_[i] : kNoIndex;
    }
    watch_.Did(passed / 16);  // some nanoseconds each
    return i;
  }

  double tolerance_m_, cell_m_;
  Buckets buckets_;
  std::vector<std::uint32_t> next_;
  const base::WorkWatch& watch_;
};

double LargestExtent(const std::vector<Vec3>& vertices) {
  Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
  for (const Vec3& v : vertices) {
    if (!IsFinite(v)) continue;
    lower = Min(lower, v);
    upper = Max(upper, v);
  }
  const Vec3 d = upper - lower;
  return std::max({d.x, d.y, d.z, 1e-9});
}

// Old index -> new index; kNoIndex where not finite. Files repeat vertices exactly: a cheap look-up of those first
// would save nothing measurable, because the cell look-up is one bucket.
std::vector<std::uint32_t> Weld(const std::vector<Vec3>& vertices, std::vector<Vec3>& kept, RepairCounts& counts,
                                const base::WorkWatch& watch) {
  Welder welder(kWeldRelative * LargestExtent(vertices), vertices.size(), watch);
  std::vector<std::uint32_t> map(vertices.size(), kNoIndex);
  std::uint32_t finite = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    watch.Did();
    if (!IsFinite(vertices[i])) continue;
    map[i] = welder.Add(vertices[i] + Vec3{});  // -0 + 0 = +0: one zero
    ++finite;
  }
  counts.welded_vertices += finite - static_cast<std::uint32_t>(welder.kept.size());
  kept = std::move(welder.kept);
  return map;
}

// |2 A| <= 1e-12 longest edge^2: no direction can be computed from it.
bool HasNoArea(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  const Vec3 ab = mesh.vertices[t[1]] - mesh.vertices[t[0]];
  const Vec3 ac = mesh.vertices[t[2]] - mesh.vertices[t[0]];
  const double longest = std::max({SquaredNorm(ab), SquaredNorm(ac), SquaredNorm(ac - ab)});
  return !(Norm(Cross(ab, ac)) > 1e-12 * longest);
}

// Finds triangles with the same three vertices, in whatever order.
class DuplicateFinder {
 public:
  explicit DuplicateFinder(std::size_t expected) : buckets_(expected) {}

  bool Seen(const Mesh& mesh, std::array<std::uint32_t, 3> t) {
    std::sort(t.begin(), t.end());
    std::uint32_t& head = buckets_.Head(Hash3(t[0], t[1], t[2]));
    for (std::uint32_t i = head; i != kNoIndex; i = next_[i]) {
      std::array<std::uint32_t, 3> other = mesh.triangles[i];
      std::sort(other.begin(), other.end());
      if (other == t) return true;
    }
    next_.push_back(head);
    head = static_cast<std::uint32_t>(mesh.triangles.size());
    return false;
  }

 private:
  Buckets buckets_;
  std::vector<std::uint32_t> next_;
};

void DropUnusedVertices(Mesh& mesh, const base::WorkWatch& watch) {
  std::vector<std::uint32_t> map(mesh.vertices.size(), kNoIndex);
  std::vector<Vec3> used;
  used.reserve(mesh.vertices.size());
  for (auto& t : mesh.triangles) {
    watch.Did();
    for (std::uint32_t& v : t) {
      if (map[v] == kNoIndex) {
        map[v] = static_cast<std::uint32_t>(used.size());
        used.push_back(mesh.vertices[v]);
      }
      v = map[v];
    }
  }
  mesh.vertices = std::move(used);
}

// A quarter of the shortest edge at each vertex of the border: what is welded within it folds no triangle.
std::vector<float> RoomAtBorder(const Mesh& mesh, const EdgeList& edges, const base::WorkWatch& watch) {
  std::vector<float> room_m(mesh.vertices.size(), 1e30F);
  for (const HalfEdge& border : edges.borders) {
    watch.Did();
    const auto& t = mesh.triangles[border.triangle];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto quarter_m = static_cast<float>(0.25 * Norm(mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]));
      for (const std::uint32_t v : {t[k], t[(k + 1) % 3]}) room_m[v] = std::min(room_m[v], quarter_m);
    }
  }
  return room_m;
}

// What becomes of each vertex of the border: of those within the tolerance, the first. kNoIndex: no such vertex.
std::vector<std::uint32_t> BorderMap(const Mesh& mesh, const EdgeList& edges, double tolerance_m,
                                     const base::WorkWatch& watch) {
  const std::vector<float> room_m = RoomAtBorder(mesh, edges, watch);
  const std::size_t most = std::min(edges.borders.size() + 1, mesh.vertices.size());
  Welder welder(tolerance_m, most / 2, watch);
  welder.Reserve(most);
  std::vector<std::uint32_t> kept, map(mesh.vertices.size(), kNoIndex);
  kept.reserve(most);
  for (const HalfEdge& border : edges.borders) {
    watch.Did();
    for (const std::uint32_t v :
         {static_cast<std::uint32_t>(border.key >> 32), static_cast<std::uint32_t>(border.key)}) {
      if (map[v] != kNoIndex) continue;
      map[v] = v;
      if (!(room_m[v] >= tolerance_m)) continue;
      const std::uint32_t place = welder.Add(mesh.vertices[v]);
      if (place == kept.size()) kept.push_back(v);
      map[v] = kept[place];
    }
  }
  return map;
}

std::uint32_t Welded(const std::vector<std::uint32_t>& map) {
  std::uint32_t welded = 0;
  for (std::uint32_t v = 0; v < map.size(); ++v) welded += map[v] != kNoIndex && map[v] != v;
  return welded;
}

// The i-th of those that have these materials and coordinates, as triangle `t`.
void KeepTriangle(const std::array<std::uint32_t, 3>& t, const std::vector<std::uint16_t>& material,
                  const std::array<std::vector<CornerUv>, kMaxUvSets>& uv, std::size_t i, Mesh& mesh) {
  mesh.triangles.push_back(t);
  mesh.material.push_back(material[i]);
  for (std::size_t set = 0; set < kMaxUvSets; ++set) {
    if (!uv[set].empty()) mesh.uv[set].push_back(uv[set][i]);
  }
}

void DropDuplicates(Mesh& mesh, const base::WorkWatch& watch) {
  Mesh kept;
  DuplicateFinder duplicates(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    watch.Did();
    if (HasNoArea(mesh, mesh.triangles[t]) || duplicates.Seen(kept, mesh.triangles[t])) continue;
    KeepTriangle(mesh.triangles[t], mesh.material, mesh.uv, t, kept);
  }
  kept.vertices = std::move(mesh.vertices);
  mesh = std::move(kept);
}

}  // namespace

StitchReport StitchCracks(Mesh& mesh, EdgeList& edges, const base::WorkWatch& watch) {
  StitchReport report;
  const std::size_t borders = edges.borders.size();
  std::vector<std::array<std::uint32_t, 3>> before;
  for (const double tolerance_m : kStitch_m) {
    if (edges.borders.empty()) break;
    const std::vector<std::uint32_t> map = BorderMap(mesh, edges, tolerance_m, watch);
    const std::uint32_t welded = Welded(map);
    if (welded == 0) continue;
    edges = {};
    if (report.welded == 0) before = mesh.triangles;
    for (auto& t : mesh.triangles) {
      for (std::uint32_t& v : t) v = map[v] == kNoIndex ? v : map[v];
    }
    report.welded += welded;
    report.within_m = tolerance_m;
    edges = ConnectEdges(mesh, watch);
  }
  if (report.welded == 0) return report;
  const bool helped = static_cast<double>(edges.borders.size()) <= kStitched * static_cast<double>(borders);
  edges = {};
  if (helped) {
    base::FreeMemory(before);
    DropDuplicates(mesh, watch);
    DropUnusedVertices(mesh, watch);
  } else {
    mesh.triangles = std::move(before);
    report = {};
  }
  edges = ConnectEdges(mesh, watch);
  return report;
}

Mesh RepairMesh(const InputObject& input, RepairCounts& counts, const base::WorkWatch& watch) {
  Mesh mesh;
  const std::vector<std::uint32_t> map = Weld(input.vertices_base_m, mesh.vertices, counts, watch);
  mesh.triangles.reserve(input.triangles.size());
  mesh.material.reserve(input.triangles.size());
  DuplicateFinder duplicates(input.triangles.size());
  for (std::size_t i = 0; i < input.triangles.size(); ++i) {
    watch.Did();
    const auto& old = input.triangles[i];
    const std::array<std::uint32_t, 3> t{map[old[0]], map[old[1]], map[old[2]]};
    if (t[0] == kNoIndex || t[1] == kNoIndex || t[2] == kNoIndex) {
      ++counts.not_finite;
    } else if (HasNoArea(mesh, t)) {
      ++counts.degenerate;
    } else if (duplicates.Seen(mesh, t)) {
      ++counts.duplicate;
    } else {
      KeepTriangle(t, input.triangle_material, input.uv, i, mesh);
    }
  }
  DropUnusedVertices(mesh, watch);
  return mesh;
}

}  // namespace omni::haptics
