#include "service/haptics/geometry/mesh_steps.h"

#include <algorithm>

#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

constexpr std::uint64_t kMaxPairs = 20'000'000;  // of edge and vertex that are compared: a fraction of a second

struct EdgeHit {
  double s;  // along the edge, (0, 1)
  std::uint32_t vertex;
};

// Border vertices sorted along the axis in which the mesh is longest.
class BorderVertices {
 public:
  BorderVertices(const Mesh& mesh, const EdgeList& edges) : mesh_(mesh) {
    for (const HalfEdge& edge : edges.borders) {
      vertices_.push_back(static_cast<std::uint32_t>(edge.key >> 32));
      vertices_.push_back(static_cast<std::uint32_t>(edge.key));
    }
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
    for (const std::uint32_t v : vertices_) {
      lower = Min(lower, mesh.vertices[v]);
      upper = Max(upper, mesh.vertices[v]);
    }
    const Vec3 d = upper - lower;
    axis_ = d.x >= d.y && d.x >= d.z ? &Vec3::x : (d.y >= d.z ? &Vec3::y : &Vec3::z);
    tolerance_m_ = kSnapRelative * std::max({d.x, d.y, d.z});
    std::sort(vertices_.begin(), vertices_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return Along(a) != Along(b) ? Along(a) < Along(b) : a < b; });
  }

  // Vertices on the open segment from a to b, in order along it.
  std::vector<EdgeHit> On(std::uint32_t a, std::uint32_t b) {
    std::vector<EdgeHit> hits;
    const Vec3 &p = mesh_.vertices[a], &q = mesh_.vertices[b];
    const Vec3 along = q - p;
    const double length2 = SquaredNorm(along);
    const double low = std::min(Along(a), Along(b)) - tolerance_m_, high = std::max(Along(a), Along(b)) + tolerance_m_;
    const auto first = std::lower_bound(vertices_.begin(), vertices_.end(), low,
                                        [&](std::uint32_t v, double x) { return Along(v) < x; });
    for (auto v = first; v != vertices_.end() && Along(*v) <= high && pairs_ < kMaxPairs; ++v, ++pairs_) {
      if (*v == a || *v == b) continue;
      const Vec3 r = mesh_.vertices[*v] - p;
      const double s = Dot(r, along) / length2;
      const bool between = s * s * length2 > tolerance_m_ * tolerance_m_ &&
                           (1 - s) * (1 - s) * length2 > tolerance_m_ * tolerance_m_ && s > 0 && s < 1;
      if (between && SquaredNorm(r - s * along) <= tolerance_m_ * tolerance_m_) hits.push_back({s, *v});
    }
    std::sort(hits.begin(), hits.end(),
              [](const EdgeHit& x, const EdgeHit& y) { return x.s != y.s ? x.s < y.s : x.vertex < y.vertex; });
    return hits;
  }

 private:
  double Along(std::uint32_t v) const { return mesh_.vertices[v].*axis_; }

  const Mesh& mesh_;
  std::vector<std::uint32_t> vertices_;
  double Vec3::*axis_ = &Vec3::x;
  double tolerance_m_ = 0;
  std::uint64_t pairs_ = 0;
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

std::uint32_t SnapTJunctions(Mesh& mesh, const EdgeList& edges) {
  if (edges.borders.empty()) return 0;
  BorderVertices vertices(mesh, edges);
  std::vector<HalfEdge> borders = edges.borders;
  std::sort(borders.begin(), borders.end(), [](const HalfEdge& x, const HalfEdge& y) {
    return x.triangle != y.triangle ? x.triangle < y.triangle : x.edge < y.edge;
  });
  std::uint32_t snapped = 0;
  std::uint32_t last = kNoIndex;  // triangle that was split
  for (const HalfEdge& edge : borders) {
    if (edge.triangle == last) continue;
    const auto& t = mesh.triangles[edge.triangle];
    const std::uint32_t apex = t[(edge.edge + 2) % 3];
    std::vector<EdgeHit> hits = vertices.On(t[edge.edge], t[(edge.edge + 1) % 3]);
    std::erase_if(hits, [&](const EdgeHit& hit) { return hit.vertex == apex; });
    if (hits.empty() || mesh.triangles.size() + hits.size() > kMaxTriangles) continue;
    SplitAtHits(mesh, edge.triangle, edge.edge, hits);
    snapped += static_cast<std::uint32_t>(hits.size());
    last = edge.triangle;
  }
  return snapped;
}

}  // namespace omni::haptics
