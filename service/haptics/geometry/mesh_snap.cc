#include "service/haptics/geometry/mesh_steps.h"

#include <algorithm>
#include <array>
#include <bit>

#include "service/haptics/geometry/tree.h"
#include "service/haptics/geometry/tree_lanes.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

struct EdgeHit {
  double s;  // along the edge, (0, 1)
  std::uint32_t vertex;
};

// The border's vertices, in a tree of their own.
class BorderVertices {
 public:
  BorderVertices(const Mesh& mesh, const EdgeList& edges, SnapBudget& budget, const base::WorkWatch& watch)
      : mesh_(mesh), budget_(budget), watch_(watch) {
    std::vector<bool> seen(mesh.vertices.size(), false);
    std::vector<TreePrimitive> points;
    Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
    for (const HalfEdge& edge : edges.borders) {
      watch.Did();
      for (const std::uint32_t v : {static_cast<std::uint32_t>(edge.key >> 32), static_cast<std::uint32_t>(edge.key)}) {
        if (seen[v]) continue;
        seen[v] = true;
        const Vec3& p = mesh.vertices[v];
        points.push_back(MakePrimitive(std::span(&p, 1), v, false));
        lower = Min(lower, p);
        upper = Max(upper, p);
      }
    }
    const Vec3 d = upper - lower;
    tolerance_m_ = kSnapRelative * std::max({d.x, d.y, d.z});
    // The slack of float boxes is 2^-19 of this, twice the tolerance at least.
    extent_m_ = 4 * std::max(LargestComponent(lower), LargestComponent(upper));
    root_ = AppendTree(points, nodes_, packets_, watch).root;
    for (TrianglePacket& packet : packets_) {
      for (int lane = 0; lane < kPacketSize; ++lane) {
        for (int k = 0; k < 3; ++k) FillPacket(packet, lane, k, mesh.vertices[packet.triangle[lane]]);
      }
    }
  }

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
        const TrianglePacket& packet = packets_[child & kChildIndex];
        for (unsigned near = static_cast<unsigned>(MeetMask(packet, segment)); near != 0; near &= near - 1) {
          const int lane = std::countr_zero(near);
          const std::uint32_t v = packet.triangle[lane];  // a packet that is not full repeats its first
          if (lane == 0 || v != packet.triangle[0]) Test(a, b, v, hits);
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
  void Test(std::uint32_t a, std::uint32_t b, std::uint32_t v, std::vector<EdgeHit>& hits) const {
    if (v == a || v == b) return;
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
  std::vector<TrianglePacket> packets_;
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

}  // namespace

SnapBudget SnapBudgetOf(const Mesh& mesh, const EdgeList& edges, std::size_t most) {
  return {.visits = 10'000 + 24 * std::uint64_t{edges.borders.size()}, .vertices = most - mesh.triangles.size()};
}

std::uint32_t SnapTJunctions(Mesh& mesh, const EdgeList& edges, SnapBudget& budget, const base::WorkWatch& watch) {
  if (edges.borders.empty() || budget.visits == 0) return 0;
  BorderVertices vertices(mesh, edges, budget, watch);
  std::vector<HalfEdge> borders = edges.borders;
  std::sort(borders.begin(), borders.end(), [&](const HalfEdge& x, const HalfEdge& y) {
    watch.Did();
    return x.triangle != y.triangle ? x.triangle < y.triangle : x.edge < y.edge;
  });
  std::uint32_t snapped = 0;
  std::uint32_t last = kNoIndex;  // triangle that was split
  for (const HalfEdge& edge : borders) {
    if (edge.triangle == last) continue;
    const auto& t = mesh.triangles[edge.triangle];
    const std::uint32_t apex = t[(edge.edge + 2) % 3];
    if (budget.visits == 0) {
      ++budget.unsearched;
      continue;
    }
    std::vector<EdgeHit> hits = vertices.On(t[edge.edge], t[(edge.edge + 1) % 3]);
    std::erase_if(hits, [&](const EdgeHit& hit) { return hit.vertex == apex; });
    if (hits.empty()) continue;
    budget.vertices -= hits.size();
    SplitAtHits(mesh, edge.triangle, edge.edge, hits);
    snapped += static_cast<std::uint32_t>(hits.size());
    last = edge.triangle;
  }
  return snapped;
}

}  // namespace omni::haptics
