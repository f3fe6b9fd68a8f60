#include "service/haptics/geometry/mesh_steps.h"

#include <algorithm>
#include <array>
#include <bit>

#include "service/haptics/geometry/tree.h"
#include "service/haptics/geometry/tree_lanes.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

// What all rounds together may spend: about as much as the rest of the build takes, and triangles up to `most`.
struct SnapBudget {
  std::uint64_t visits = 0;      // of nodes and leaves of the tree of border vertices; 0: nothing is split any more
  std::uint64_t vertices = 0;    // that split an edge
  std::uint32_t unsearched = 0;  // edges that were left, because one of these was spent
  void Spend(std::uint64_t work) { visits -= std::min(visits, work); }
};

constexpr int kMaxSnapRounds = 8;

struct EdgeHit {
  double s;  // along the edge, (0, 1)
  std::uint32_t vertex;
};

struct SplitEdge {
  std::uint32_t triangle, edge;
  std::vector<EdgeHit> hits;
};

// The border's vertices, in a tree of their own.
class BorderVertices {
 public:
  BorderVertices(const Mesh& mesh, const EdgeList& edges, SnapBudget& budget, const base::WorkWatch& watch)
      : mesh_(mesh), budget_(budget), watch_(watch) {
    SetBorders(edges);
    std::vector<TreePrimitive> points;
    Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      if (!on_border_[v]) continue;
      watch.Did();
      const Vec3& p = mesh.vertices[v];
      points.push_back(MakePrimitive(std::span(&p, 1), v, false));
      lower = Min(lower, p);
      upper = Max(upper, p);
    }
    const Vec3 d = upper - lower;
    tolerance_m_ = kSnapRelative * std::max({d.x, d.y, d.z});
    // The slack of float boxes is 2^-19 of this, twice the tolerance at least.
    extent_m_ = 4 * std::max(LargestComponent(lower), LargestComponent(upper));
    root_ = AppendTree(points, 0, nodes_, watch).root;
    order_.reserve(points.size());
    for (const TreePrimitive& point : points) order_.push_back(point.triangle);
    // The last leaf is loaded as if it were full.
    for (std::vector<float>* values : {&x_, &y_, &z_}) values->resize(order_.size() + kLeafSize);
    for (std::size_t i = 0; i < order_.size(); ++i) {
      watch.Did();
      const Vec3& p = mesh.vertices[order_[i]];
      x_[i] = static_cast<float>(p.x);
      y_[i] = static_cast<float>(p.y);
      z_[i] = static_cast<float>(p.z);
    }
  }

  // After edges were split: no vertex comes to the border by that, some leave it.
  void SetBorders(const EdgeList& edges) {
    on_border_.assign(mesh_.vertices.size(), false);
    for (const HalfEdge& edge : edges.borders) {
      watch_.Did();
      on_border_[edge.key >> 32] = on_border_[static_cast<std::uint32_t>(edge.key)] = true;
    }
  }

  // Vertices that are near each other are near each other in this order, too.
  const std::vector<std::uint32_t>& order() const { return order_; }

  // Vertices on the open segment from a to b, in order along it; none once the budget is spent.
  std::vector<EdgeHit> On(std::uint32_t a, std::uint32_t b) {
    std::vector<EdgeHit> hits;
    const Vec3 &p = mesh_.vertices[a], &q = mesh_.vertices[b];
    const SegmentLanes segment(p, q, extent_m_);
    std::array<std::uint32_t, kTreeWidth * kMaxTreeDepth> stack;
    std::size_t size = 0;
    stack[size++] = root_;
    while (size > 0) {
      if (budget_.visits == 0) return {};
      if (hits.size() > budget_.vertices) break;
      budget_.Spend(1);
      watch_.Did();
      const TreeNode& node = nodes_[stack[--size]];
      for (unsigned meets = static_cast<unsigned>(MeetMask(node, segment)); meets != 0; meets &= meets - 1) {
        const std::uint32_t child = node.child[std::countr_zero(meets)];
        if ((child & kLeafBit) == 0) {
          stack[size++] = child;
          continue;
        }
        budget_.Spend(1);
        const LeafRange leaf = LeafRange::Of(child);
        for (unsigned near = leaf.LaneMask() & MayLieOn(segment, leaf.first); near != 0; near &= near - 1) {
          Test(a, b, order_[leaf.first + static_cast<unsigned>(std::countr_zero(near))], hits);
        }
      }
    }
    if (hits.size() > budget_.vertices) {
      budget_.visits = 0;
      return {};
    }
    std::sort(hits.begin(), hits.end(),
              [](const EdgeHit& x, const EdgeHit& y) { return x.s != y.s ? x.s < y.s : x.vertex < y.vertex; });
    budget_.Spend(8 * hits.size());
    return hits;
  }

 private:
  // One bit for each of the vertices from `first` on, in the order of the leaves.
  unsigned MayLieOn(const SegmentLanes& segment, std::uint32_t first) const {
    const Lanes3 points{_mm_loadu_ps(&x_[first]), _mm_loadu_ps(&y_[first]), _mm_loadu_ps(&z_[first])};
    return static_cast<unsigned>(_mm_movemask_ps(MayMeet(segment, points, points)));
  }

  void Test(std::uint32_t a, std::uint32_t b, std::uint32_t v, std::vector<EdgeHit>& hits) const {
    if (v == a || v == b || !on_border_[v]) return;
    const Vec3 along = mesh_.vertices[b] - mesh_.vertices[a], r = mesh_.vertices[v] - mesh_.vertices[a];
    const double length2 = SquaredNorm(along);
    const double s = Dot(r, along) / length2;
    const bool between = s * s * length2 > tolerance_m_ * tolerance_m_ &&
                         (1 - s) * (1 - s) * length2 > tolerance_m_ * tolerance_m_ && s > 0 && s < 1;
    if (between && SquaredNorm(r - s * along) <= tolerance_m_ * tolerance_m_) hits.push_back({s, v});
  }

  const Mesh& mesh_;
  SnapBudget& budget_;
  const base::WorkWatch& watch_;
  std::vector<TreeNode> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<float> x_, y_, z_;  // rounded, in this order
  std::vector<bool> on_border_;
  std::uint32_t root_ = 0;
  double tolerance_m_ = 0, extent_m_ = 0;
};

// Triangle t, edge k from a to b, apex c: becomes the fan (a, m1, c), (m1, m2, c), ... (mn, b, c).
void SplitAtHits(Mesh& mesh, std::uint32_t t, std::uint32_t k, const std::vector<EdgeHit>& hits) {
  const std::array<std::uint32_t, 3> old = mesh.triangles[t];
  const std::size_t ka = k, kb = (k + 1) % 3, kc = (k + 2) % 3;
  std::array<CornerUv, kMaxUvSets> old_uv{};
  for (std::size_t set = 0; set < kMaxUvSets; ++set) {
    if (!mesh.uv[set].empty()) old_uv[set] = mesh.uv[set][t];
  }
  for (std::size_t i = 0; i <= hits.size(); ++i) {
    const std::uint32_t from = i == 0 ? old[ka] : hits[i - 1].vertex, to = i == hits.size() ? old[kb] : hits[i].vertex;
    const double s_from = i == 0 ? 0 : hits[i - 1].s, s_to = i == hits.size() ? 1 : hits[i].s;
    if (i > 0) {
      mesh.triangles.emplace_back();
      mesh.material.push_back(mesh.material[t]);
    }
    std::array<std::uint32_t, 3>& triangle = i == 0 ? mesh.triangles[t] : mesh.triangles.back();
    triangle = {from, to, old[kc]};
    for (std::size_t set = 0; set < kMaxUvSets; ++set) {
      if (mesh.uv[set].empty()) continue;
      CornerUv uv{};
      for (std::size_t c = 0; c < 2; ++c) {
        const auto at = [&](double s) {
          return static_cast<float>((1 - s) * old_uv[set][2 * ka + c] + s * old_uv[set][2 * kb + c]);
        };
        uv[c] = at(s_from);
        uv[2 + c] = at(s_to);
        uv[4 + c] = old_uv[set][2 * kc + c];
      }
      if (i == 0) {
        mesh.uv[set][t] = uv;
      } else {
        mesh.uv[set].push_back(uv);
      }
    }
  }
}

class Snapper {
 public:
  Snapper(Mesh& mesh, EdgeList& edges, std::size_t most, const base::WorkWatch& watch)
      : mesh_(mesh),
        edges_(edges),
        watch_(watch),
        budget_{.visits = 10'000 + 24 * std::uint64_t{edges.borders.size()}, .vertices = most - mesh.triangles.size()},
        vertices_(mesh, edges, budget_, watch),
        changed_(mesh.triangles.size(), true) {}

  SnapReport Run() {
    SnapReport report;
    for (int round = 0; round < kMaxSnapRounds; ++round) {
      const std::uint32_t split = Split(Find());
      if (split == 0) break;
      report.split += split;
      edges_ = {};  // two at a time would be the largest part of a build
      edges_ = ConnectEdges(mesh_, watch_);
      vertices_.SetBorders(edges_);
    }
    report.unsearched = budget_.unsearched;
    return report;
  }

 private:
  // Border edges of changed triangles that have vertices on them. Edges that are near each other are searched one after
  // the other: the tree is larger than a cache.
  std::vector<SplitEdge> Find() {
    const std::vector<HalfEdge>& borders = edges_.borders;
    std::vector<std::uint32_t> first(mesh_.vertices.size(), kNoIndex);  // border of which this is the smaller vertex
    for (std::size_t i = borders.size(); i-- > 0;) first[borders[i].key >> 32] = static_cast<std::uint32_t>(i);
    std::vector<SplitEdge> splits;
    for (const std::uint32_t v : vertices_.order()) {
      for (std::size_t i = first[v]; i < borders.size() && borders[i].key >> 32 == v; ++i) {
        watch_.Did();
        const auto [key, triangle, k] = borders[i];
        if (!changed_[triangle]) continue;
        if (budget_.visits == 0) {
          ++budget_.unsearched;
          continue;
        }
        const auto& t = mesh_.triangles[triangle];
        SplitEdge split{triangle, k, vertices_.On(t[k], t[(k + 1) % 3])};
        std::erase_if(split.hits, [apex = t[(k + 2) % 3]](const EdgeHit& hit) { return hit.vertex == apex; });
        if (split.hits.empty()) continue;
        budget_.vertices -= split.hits.size();
        splits.push_back(std::move(split));
      }
    }
    return splits;
  }

  // One edge of a triangle at a time. The number of vertices that split an edge.
  std::uint32_t Split(std::vector<SplitEdge> splits) {
    std::sort(splits.begin(), splits.end(), [&](const SplitEdge& x, const SplitEdge& y) {
      watch_.Did();
      return x.triangle != y.triangle ? x.triangle < y.triangle : x.edge < y.edge;
    });
    changed_.assign(mesh_.triangles.size(), false);
    std::uint32_t count = 0;
    std::uint32_t last = kNoIndex;
    for (const SplitEdge& split : splits) {
      if (split.triangle == last) {
        budget_.vertices += split.hits.size();
        continue;
      }
      last = split.triangle;
      SplitAtHits(mesh_, split.triangle, split.edge, split.hits);
      count += static_cast<std::uint32_t>(split.hits.size());
      changed_[split.triangle] = true;
      changed_.resize(mesh_.triangles.size(), true);
    }
    return count;
  }

  Mesh& mesh_;
  EdgeList& edges_;
  const base::WorkWatch& watch_;
  SnapBudget budget_;
  BorderVertices vertices_;
  std::vector<bool> changed_;  // triangles, since their edges were searched
};

}  // namespace

SnapReport SnapTJunctions(Mesh& mesh, EdgeList& edges, std::size_t most, const base::WorkWatch& watch) {
  if (edges.borders.empty()) return {};
  return Snapper(mesh, edges, most, watch).Run();
}

}  // namespace omni::haptics
