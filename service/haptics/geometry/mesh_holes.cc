#include "service/haptics/geometry/mesh_steps.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

// Border corners around a hole in the order in which its triangles have to run.
struct Loop {
  std::vector<std::uint32_t> vertices;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> corners;  // triangle and corner each vertex was taken from
  std::uint32_t component = 0;
};

double Diagonal(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
  Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
  for (const std::uint32_t v : vertices) {
    lower = Min(lower, mesh.vertices[v]);
    upper = Max(upper, mesh.vertices[v]);
  }
  return Norm(upper - lower);
}

std::vector<double> DiagonalsOf(const Mesh& mesh, std::uint32_t components, const base::WorkWatch& watch) {
  std::vector<Vec3> lower(components, {1e30, 1e30, 1e30}), upper(components, {-1e30, -1e30, -1e30});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    watch.Did();
    for (const std::uint32_t v : mesh.triangles[t]) {
      lower[mesh.component[t]] = Min(lower[mesh.component[t]], mesh.vertices[v]);
      upper[mesh.component[t]] = Max(upper[mesh.component[t]], mesh.vertices[v]);
    }
  }
  std::vector<double> diagonals(components);
  for (std::size_t c = 0; c < components; ++c) diagonals[c] = Norm(upper[c] - lower[c]);
  return diagonals;
}

// Borders chained to loops. A hole is run round against its triangles: from the end of a border edge to its start.
class LoopFinder {
 public:
  LoopFinder(const Mesh& mesh, const EdgeList& edges, const base::WorkWatch& watch)
      : mesh_(mesh), borders_(edges.borders), watch_(watch), ending_(mesh.vertices.size(), kNoIndex) {
    for (std::uint32_t i = 0; i < borders_.size(); ++i) {
      watch.Did();
      std::uint32_t& ending = ending_[End(i)];
      ending = ending == kNoIndex ? i : kSeveral;
    }
  }

  // Loops short enough; `open` marks components with any border that is in none of them.
  std::vector<Loop> Run(std::vector<bool>& open) {
    std::vector<Loop> loops;
    std::vector<bool> used(borders_.size(), false);
    for (std::uint32_t i = 0; i < borders_.size(); ++i) {
      if (used[i]) continue;
      Loop loop;
      loop.component = mesh_.component[borders_[i].triangle];
      bool closed = false;
      for (std::uint32_t at = i; loop.vertices.size() <= kMaxHoleEdges;) {
        watch_.Did();
        used[at] = true;
        loop.vertices.push_back(End(at));
        loop.corners.emplace_back(borders_[at].triangle, (borders_[at].edge + 1) % 3);
        const std::uint32_t next = ending_[Start(at)];
        if (next == kNoIndex || next == kSeveral) break;
        at = next;
        closed = at == i;
        if (closed || used[at]) break;
      }
      if (closed && loop.vertices.size() >= 3 && loop.vertices.size() <= kMaxHoleEdges && loops.size() < kMaxHoles) {
        loops.push_back(std::move(loop));
      } else {
        open[loop.component] = true;
      }
    }
    return loops;
  }

 private:
  static constexpr std::uint32_t kSeveral = kNoIndex - 1;  // borders (a bow tie): which goes on is not known

  std::uint32_t Start(std::uint32_t i) const { return mesh_.triangles[borders_[i].triangle][borders_[i].edge]; }
  std::uint32_t End(std::uint32_t i) const { return mesh_.triangles[borders_[i].triangle][(borders_[i].edge + 1) % 3]; }

  const Mesh& mesh_;
  const std::vector<HalfEdge>& borders_;
  const base::WorkWatch& watch_;
  std::vector<std::uint32_t> ending_;  // of each vertex: the border that ends there
};

// W(i, k) = min over i < j < k of W(i, j) + W(j, k) + area(i, j, k). A diagonal that is an edge already would have
// three triangles; one without area has no normal: both are not used.
class Triangulator {
 public:
  Triangulator(const Mesh& mesh, const EdgeList& edges, const Loop& loop)
      : mesh_(mesh), edges_(edges), loop_(loop), n_(loop.vertices.size()), weight_(n_ * n_, 0), split_(n_ * n_, 0) {}

  // False: there is none.
  bool Run(std::vector<std::array<std::size_t, 3>>& triangles, const base::WorkWatch& watch) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    for (std::size_t span = 2; span < n_; ++span) {
      for (std::size_t i = 0; i + span < n_; ++i) {
        const std::size_t k = i + span;
        watch.Did(1 + span / 16);  // some nanoseconds each
        double& best = weight_[i * n_ + k];
        best = kNone;
        const bool closing = span == n_ - 1;  // the last side of the loop, not a diagonal
        if (!closing && edges_.Has(loop_.vertices[i], loop_.vertices[k])) continue;
        for (std::size_t j = i + 1; j < k; ++j) {
          const double area = Area(i, j, k);
          const double sum = weight_[i * n_ + j] + weight_[j * n_ + k] + area;
          if (area > 0 && sum < best) {
            best = sum;
            split_[i * n_ + k] = j;
          }
        }
      }
    }
    if (!(weight_[n_ - 1] < kNone)) return false;
    Collect(0, n_ - 1, triangles);
    return true;
  }

 private:
  double Area(std::size_t i, std::size_t j, std::size_t k) const {
    const Vec3 &a = mesh_.vertices[loop_.vertices[i]], &b = mesh_.vertices[loop_.vertices[j]],
               &c = mesh_.vertices[loop_.vertices[k]];
    const double twice = Norm(Cross(b - a, c - a));
    const double longest = std::max({SquaredNorm(b - a), SquaredNorm(c - a), SquaredNorm(c - b)});
    return twice > 1e-9 * longest ? twice / 2 : 0;
  }

  void Collect(std::size_t i, std::size_t k, std::vector<std::array<std::size_t, 3>>& triangles) const {
    if (k < i + 2) return;
    const std::size_t j = split_[i * n_ + k];
    triangles.push_back({i, j, k});
    Collect(i, j, triangles);
    Collect(j, k, triangles);
  }

  const Mesh& mesh_;
  const EdgeList& edges_;
  const Loop& loop_;
  const std::size_t n_;
  std::vector<double> weight_;
  std::vector<std::size_t> split_;
};

void AddFilling(Mesh& mesh, const Loop& loop, const std::vector<std::array<std::size_t, 3>>& triangles) {
  const std::uint16_t material = mesh.material[loop.corners[0].first];
  for (const auto& t : triangles) {
    mesh.triangles.push_back({loop.vertices[t[0]], loop.vertices[t[1]], loop.vertices[t[2]]});
    mesh.material.push_back(material);
    for (std::vector<CornerUv>& set : mesh.uv) {
      if (set.empty()) continue;
      CornerUv uv{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& [triangle, corner] = loop.corners[t[k]];
        uv[2 * k] = set[triangle][2 * corner];
        uv[2 * k + 1] = set[triangle][2 * corner + 1];
      }
      set.push_back(uv);
    }
  }
}

}  // namespace

std::uint32_t CloseSmallHoles(Mesh& mesh, const EdgeList& edges, std::uint32_t components, std::size_t most,
                              const base::WorkWatch& watch) {
  if (edges.borders.empty()) return 0;
  std::vector<bool> open(components, false);
  const std::vector<Loop> loops = LoopFinder(mesh, edges, watch).Run(open);
  const std::vector<double> diagonals = DiagonalsOf(mesh, components, watch);
  std::vector<std::vector<std::array<std::size_t, 3>>> fillings(loops.size());
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const Loop& loop = loops[i];
    if (open[loop.component]) continue;
    const bool small = Diagonal(mesh, loop.vertices) <= kMaxHoleRelative * diagonals[loop.component];
    if (!small || !Triangulator(mesh, edges, loop).Run(fillings[i], watch)) open[loop.component] = true;
  }
  std::uint32_t closed = 0;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (open[loops[i].component] || mesh.triangles.size() + fillings[i].size() > most) continue;
    AddFilling(mesh, loops[i], fillings[i]);
    ++closed;
  }
  return closed;
}

}  // namespace omni::haptics
