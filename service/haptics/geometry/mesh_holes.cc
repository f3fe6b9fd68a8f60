#include "service/haptics/geometry/mesh_steps.h"

#include <algorithm>
#include <limits>
#include <set>
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
// Where a vertex has several holes, the way goes on along the nearest border, and closes at the first vertex that it
// meets again: so holes that share a vertex are loops of their own.
class LoopFinder {
 public:
  LoopFinder(const Mesh& mesh, const EdgeList& edges, const base::WorkWatch& watch)
      : mesh_(mesh),
        borders_(edges.borders),
        watch_(watch),
        ending_(mesh.vertices.size(), kNoIndex),
        next_ending_(borders_.size(), kNoIndex),
        used_(borders_.size(), false),
        place_(mesh.vertices.size(), kNoIndex) {
    for (auto i = static_cast<std::uint32_t>(borders_.size()); i-- > 0;) {
      watch.Did();
      next_ending_[i] = ending_[End(i)];
      ending_[End(i)] = i;
    }
  }

  // Loops short enough; `open` marks components with any border that is in none of them.
  std::vector<Loop> Run(std::vector<bool>& open) {
    std::vector<Loop> loops;
    for (std::uint32_t seed = 0; seed < borders_.size(); ++seed) {
      for (std::uint32_t at = used_[seed] ? kNoIndex : seed; at != kNoIndex; at = Next()) {
        watch_.Did();
        used_[at] = true;
        place_[End(at)] = static_cast<std::uint32_t>(way_.size());
        way_.push_back(at);
        if (place_[Start(at)] != kNoIndex) TakeLoop(place_[Start(at)], loops, open);
      }
      for (const std::uint32_t i : way_) open[mesh_.component[borders_[i].triangle]] = true;  // it leads nowhere
      Forget(0);
    }
    return loops;
  }

 private:
  static constexpr int kMostAsked = 16;  // of borders at one vertex

  std::uint32_t Start(std::uint32_t i) const { return mesh_.triangles[borders_[i].triangle][borders_[i].edge]; }
  std::uint32_t End(std::uint32_t i) const { return mesh_.triangles[borders_[i].triangle][(borders_[i].edge + 1) % 3]; }

  // The way so far, from `first` on, is a loop.
  void TakeLoop(std::uint32_t first, std::vector<Loop>& loops, std::vector<bool>& open) {
    Loop loop;
    loop.component = mesh_.component[borders_[way_[first]].triangle];
    const std::size_t count = way_.size() - first;
    if (count >= 3 && count <= kMaxHoleEdges && loops.size() < kMaxHoles) {
      for (std::size_t k = first; k < way_.size(); ++k) {
        loop.vertices.push_back(End(way_[k]));
        loop.corners.emplace_back(borders_[way_[k]].triangle, (borders_[way_[k]].edge + 1) % 3);
      }
      loops.push_back(std::move(loop));
    } else {
      open[loop.component] = true;
    }
    Forget(first);
  }
  void Forget(std::size_t first) {
    for (std::size_t k = first; k < way_.size(); ++k) place_[End(way_[k])] = kNoIndex;
    way_.resize(first);
  }

  // The unused border from where the way has come to, the one nearest to its last.
  std::uint32_t Next() const {
    const std::uint32_t v = way_.empty() ? kNoIndex : Start(way_.back());
    if (v == kNoIndex) return kNoIndex;
    const Vec3 back = Normalized(mesh_.vertices[End(way_.back())] - mesh_.vertices[v]);
    std::uint32_t best = kNoIndex;
    double best_cosine = -2;
    int asked = 0;
    for (std::uint32_t i = ending_[v]; i != kNoIndex && asked < kMostAsked; i = next_ending_[i]) {
      ++asked;
      if (used_[i]) continue;
      const double cosine = Dot(back, Normalized(mesh_.vertices[Start(i)] - mesh_.vertices[v]));
      if (!(cosine > best_cosine)) continue;
      best = i;
      best_cosine = cosine;
    }
    return best;
  }

  const Mesh& mesh_;
  const std::vector<HalfEdge>& borders_;
  const base::WorkWatch& watch_;
  std::vector<std::uint32_t> ending_, next_ending_;  // of each vertex, the borders that end there
  std::vector<bool> used_;
  std::vector<std::uint32_t> way_;    // borders, each ending where the one before starts
  std::vector<std::uint32_t> place_;  // of a vertex, at which a border of the way ends
};

// W(i, k) = min over i < j < k of W(i, j) + W(j, k) + area(i, j, k). A diagonal that is an edge already would have
// three triangles; one without area has no normal: both are not used.
class Triangulator {
 public:
  // `added`: edges of holes that were filled before.
  Triangulator(const Mesh& mesh, const EdgeList& edges, const std::set<std::uint64_t>& added, const Loop& loop)
      : mesh_(mesh),
        edges_(edges),
        added_(added),
        loop_(loop),
        n_(loop.vertices.size()),
        weight_(n_ * n_, 0),
        split_(n_ * n_, 0) {}

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
        if (!closing && Has(loop_.vertices[i], loop_.vertices[k])) continue;
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
  bool Has(std::uint32_t a, std::uint32_t b) const { return edges_.Has(a, b) || added_.contains(EdgeKey(a, b)); }

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
  const std::set<std::uint64_t>& added_;
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

// How far each component is from closed: |sum of area vectors| over its area   (R.3)
std::vector<double> OpennessOf(const Mesh& mesh, std::uint32_t components, const base::WorkWatch& watch) {
  std::vector<Vec3> sum(components);
  std::vector<double> area(components, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    watch.Did();
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 twice = Cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
    sum[mesh.component[t]] = sum[mesh.component[t]] + twice;
    area[mesh.component[t]] += Norm(twice);
  }
  std::vector<double> openness(components);
  for (std::size_t c = 0; c < components; ++c) openness[c] = Norm(sum[c]) / area[c];
  return openness;
}

// Steps of the triangulations of all holes, about as long as the rest of the build takes.
constexpr std::uint64_t kHoleWork = 3'000'000, kHoleWorkPerTriangle = 700;

std::uint64_t WorkOf(const Loop& loop) {
  const std::uint64_t n = loop.vertices.size();
  return n * n * n / 6;
}

// One by one, the smallest first.
class HoleFiller {
 public:
  HoleFiller(Mesh& mesh, const EdgeList& edges, std::vector<Loop> loops, std::vector<bool>& open, std::size_t most,
             const base::WorkWatch& watch)
      : mesh_(mesh), edges_(edges), loops_(std::move(loops)), open_(open), most_(most), watch_(watch) {}

  std::uint32_t Run(std::uint32_t components) {
    const std::vector<double> diagonals = DiagonalsOf(mesh_, components, watch_);
    std::uint64_t left = kHoleWork + kHoleWorkPerTriangle * mesh_.triangles.size();
    std::stable_sort(loops_.begin(), loops_.end(),
                     [](const Loop& a, const Loop& b) { return a.vertices.size() < b.vertices.size(); });
    for (Loop& loop : loops_) {
      const std::uint64_t work = WorkOf(loop);
      const bool small = Diagonal(mesh_, loop.vertices) <= kMaxHoleRelative * diagonals[loop.component];
      if (small && work <= left) {
        left -= work;
        continue;
      }
      open_[loop.component] = true;
      loop.vertices.clear();
    }
    const std::vector<double> openness = OpennessOf(mesh_, components, watch_);
    std::uint32_t filled = 0;
    for (const Loop& loop : loops_) {
      const bool is_sheet = open_[loop.component] && openness[loop.component] > kMostOpen;
      if (!loop.vertices.empty() && !is_sheet) filled += Fill(loop);
    }
    return filled;
  }

 private:
  bool Fill(const Loop& loop) {
    std::vector<std::array<std::size_t, 3>> triangles;
    if (mesh_.triangles.size() + loop.vertices.size() > most_) return false;
    if (!Triangulator(mesh_, edges_, added_, loop).Run(triangles, watch_)) return false;
    AddFilling(mesh_, loop, triangles);
    for (const auto& t : triangles) {
      for (std::size_t k = 0; k < 3; ++k) added_.insert(EdgeKey(loop.vertices[t[k]], loop.vertices[t[(k + 1) % 3]]));
    }
    return true;
  }

  Mesh& mesh_;
  const EdgeList& edges_;
  std::vector<Loop> loops_;
  std::vector<bool>& open_;
  std::size_t most_;
  const base::WorkWatch& watch_;
  std::set<std::uint64_t> added_;
};

}  // namespace

std::uint32_t CloseSmallHoles(Mesh& mesh, const EdgeList& edges, std::uint32_t components, std::size_t most,
                              const base::WorkWatch& watch) {
  if (edges.borders.empty()) return 0;
  std::vector<bool> open(components, false);
  std::vector<Loop> loops = LoopFinder(mesh, edges, watch).Run(open);
  if (loops.empty()) return 0;
  return HoleFiller(mesh, edges, std::move(loops), open, most, watch).Run(components);
}

}  // namespace omni::haptics
