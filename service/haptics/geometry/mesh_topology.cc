#include "service/haptics/geometry/mesh_topology.h"

#include <algorithm>
#include <numbers>

#include "service/haptics/scene.h"

namespace omni::haptics {
namespace {

using Corner3 = std::array<std::uint32_t, 3>;

struct HalfEdge {
  std::uint64_t key;  // smaller vertex, larger vertex
  std::uint32_t triangle;
  std::uint32_t edge;
};

// Pairs the triangles at each edge; edges of one or of three and more triangles stay without neighbour.
void Connect(Mesh& mesh, TopologyReport& report) {
  const std::size_t n = mesh.triangles.size();
  mesh.neighbours.assign(n, Corner3{kNoIndex, kNoIndex, kNoIndex});
  std::vector<HalfEdge> edges;
  edges.reserve(3 * n);
  for (std::uint32_t t = 0; t < n; ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      edges.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), t, k});
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
    report.border_edges += end - i == 1;
    report.non_manifold_edges += end - i > 2;
    i = end;
  }
}

std::uint32_t EdgeTo(const Mesh& mesh, std::uint32_t triangle, std::uint32_t a, std::uint32_t b) {
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t x = mesh.triangles[triangle][k], y = mesh.triangles[triangle][(k + 1) % 3];
    if ((x == a && y == b) || (x == b && y == a)) return k;
  }
  return 3;
}

// (a, b, c) -> (a, c, b): edges 0 and 2 change places, edge 1 stays.
void Flip(Mesh& mesh, std::uint32_t t) {
  std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  std::swap(mesh.neighbours[t][0], mesh.neighbours[t][2]);
}

// Breadth first from each unvisited triangle: two neighbours agree if they run through their edge in opposite
// directions.
void OrientComponents(Mesh& mesh, TopologyReport& report) {
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

struct ComponentFacts {
  double volume_m3 = 0;  // signed
  bool closed = true;
  Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
  std::vector<Vec3> samples;  // some of its vertices
};

// V = 1/6 sum a . (b x c), relative to a vertex of the mesh so that far-away meshes keep their digits.
std::vector<ComponentFacts> Facts(const Mesh& mesh, std::uint32_t count) {
  std::vector<ComponentFacts> facts(count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    ComponentFacts& f = facts[mesh.component[t]];
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& v = mesh.vertices[mesh.triangles[t][k]];
      c[k] = v - mesh.vertices[0];
      f.lower = Min(f.lower, v);
      f.upper = Max(f.upper, v);
      f.closed = f.closed && mesh.neighbours[t][k] != kNoIndex;
    }
    f.volume_m3 += Dot(c[0], Cross(c[1], c[2])) / 6;
    if (f.samples.size() < 8) f.samples.push_back(mesh.vertices[mesh.triangles[t][0]]);
  }
  return facts;
}

// tan(omega / 2) = a.(b x c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)   [van Oosterom & Strackee 1983]
double SolidAngle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = Norm(a), lb = Norm(b), lc = Norm(c);
  return 2 * std::atan2(Dot(a, Cross(b, c)), la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb);
}

bool BoxContains(const ComponentFacts& outer, const ComponentFacts& inner) {
  return outer.lower.x < inner.lower.x && outer.lower.y < inner.lower.y && outer.lower.z < inner.lower.z &&
         outer.upper.x > inner.upper.x && outer.upper.y > inner.upper.y && outer.upper.z > inner.upper.z;
}

bool IsInside(const Mesh& mesh, std::uint32_t outer, const Vec3& p) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.component[t] != outer) continue;
    const auto& v = mesh.triangles[t];
    sum += SolidAngle(mesh.vertices[v[0]] - p, mesh.vertices[v[1]] - p, mesh.vertices[v[2]] - p);
  }
  return std::abs(sum) > 2 * std::numbers::pi;
}

bool IsCavity(const Mesh& mesh, const std::vector<ComponentFacts>& facts, std::uint32_t inner) {
  for (std::uint32_t outer = 0; outer < facts.size(); ++outer) {
    if (outer == inner || !facts[outer].closed || !BoxContains(facts[outer], facts[inner])) continue;
    if (std::all_of(facts[inner].samples.begin(), facts[inner].samples.end(),
                    [&](const Vec3& p) { return IsInside(mesh, outer, p); })) {
      return true;
    }
  }
  return false;
}

// Closed components get a positive volume. A negative one wholly inside another is the wall of a cavity: right as it
// is.
void OrientOutwards(Mesh& mesh, TopologyReport& report) {
  constexpr std::uint32_t kMaxCavityTests = 16;  // each costs a pass over the mesh; what comes later is turned outwards
  const std::vector<ComponentFacts> facts = Facts(mesh, report.components);
  std::vector<bool> flip(facts.size(), false);
  std::uint32_t tests = 0;
  for (std::uint32_t c = 0; c < facts.size(); ++c) {
    if (!facts[c].closed || !(facts[c].volume_m3 < 0)) continue;
    if (facts.size() > 1 && tests++ < kMaxCavityTests && IsCavity(mesh, facts, c)) {
      ++report.cavities;
    } else {
      flip[c] = true;
      ++report.flipped_components;
    }
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (flip[mesh.component[t]]) Flip(mesh, t);
  }
}

}  // namespace

TopologyReport ConnectAndOrient(Mesh& mesh) {
  TopologyReport report;
  if (mesh.triangles.empty()) return report;
  Connect(mesh, report);
  OrientComponents(mesh, report);
  OrientOutwards(mesh, report);
  return report;
}

}  // namespace omni::haptics
