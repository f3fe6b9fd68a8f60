#include "scenes/generator/mesh/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <queue>

namespace omni::scenes {
namespace {

// Sum of squared distances to planes n.p + d = 0:  p'A p + 2 b.p + c
struct Quadric {
  glm::dmat3 A{0.0};
  Vec b{0.0};
  double c = 0;

  void AddPlane(const Vec& n, double d, double weight) {
    A += glm::outerProduct(n, n) * weight;
    b += n * (d * weight);
    c += d * d * weight;
  }
  Quadric operator+(const Quadric& o) const { return {A + o.A, b + o.b, c + o.c}; }
  double At(const Vec& p) const { return glm::dot(p, A * p) + 2 * glm::dot(b, p) + c; }
};

struct Candidate {
  double cost;
  std::uint32_t a, b;
  std::uint32_t stamp_a, stamp_b;
  Vec p;
  // Cheapest first; ties by number, so that the order does not depend on the heap.
  bool operator<(const Candidate& o) const {
    if (cost != o.cost) return cost > o.cost;
    return a != o.a ? a > o.a : b > o.b;
  }
};

class Decimator {
 public:
  Decimator(const Mesh& mesh, const std::vector<double>& importance)
      : p_(mesh.positions),
        triangles_(mesh.triangles),
        alive_(mesh.triangles.size(), true),
        quadric_(mesh.positions.size()),
        stamp_(mesh.positions.size(), 0),
        of_vertex_(mesh.positions.size()),
        count_(mesh.triangles.size()) {
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      const Vec n = Normal(triangles_[t]);
      const double area = glm::length(n) / 2;
      for (const std::uint32_t v : triangles_[t]) {
        of_vertex_[v].push_back(t);
        if (area > 0) quadric_[v].AddPlane(n / (2 * area), -glm::dot(n / (2 * area), p_[v]), area * importance[v]);
      }
    }
    for (std::uint32_t v = 0; v < p_.size(); ++v) {
      // A weak pull to the vertex itself keeps flat places well conditioned.
      const double w = 1e-4 * importance[v];
      quadric_[v].A += glm::dmat3(w);
      quadric_[v].b -= p_[v] * w;
      quadric_[v].c += glm::dot(p_[v], p_[v]) * w;
    }
    for (const Triangle& t : triangles_) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (t[k] < t[(k + 1) % 3]) Push(t[k], t[(k + 1) % 3]);
      }
    }
  }

  Mesh Run(std::size_t wanted) {
    while (count_ > wanted && !heap_.empty()) {
      const Candidate best = heap_.top();
      heap_.pop();
      if (best.stamp_a != stamp_[best.a] || best.stamp_b != stamp_[best.b]) continue;
      if (MayCollapse(best)) Collapse(best);
    }
    return Compact();
  }

 private:
  static constexpr std::uint32_t kGone = 0xFFFFFFFF;

  Vec Normal(const Triangle& t) const { return glm::cross(p_[t[1]] - p_[t[0]], p_[t[2]] - p_[t[0]]); }

  void Push(std::uint32_t a, std::uint32_t b) {
    const Quadric q = quadric_[a] + quadric_[b];
    Vec p = (p_[a] + p_[b]) * 0.5;
    const double determinant = glm::determinant(q.A);
    if (std::abs(determinant) > 1e-14) {
      const Vec best = glm::inverse(q.A) * -q.b;
      if (glm::length(best - p) < 2 * glm::length(p_[a] - p_[b])) p = best;
    }
    heap_.push(
        {std::max(q.At(p), 0.0), std::min(a, b), std::max(a, b), stamp_[std::min(a, b)], stamp_[std::max(a, b)], p});
  }

  std::vector<std::uint32_t> Neighbours(std::uint32_t v) const {
    std::vector<std::uint32_t> ring;
    for (const std::uint32_t t : of_vertex_[v]) {
      if (!alive_[t]) continue;
      for (const std::uint32_t other : triangles_[t]) {
        if (other != v) ring.push_back(other);
      }
    }
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
  }

  // Link condition: the two rings share exactly the two vertices opposite the edge; and no triangle turns over.
  bool MayCollapse(const Candidate& edge) const {
    const std::vector<std::uint32_t> ring_a = Neighbours(edge.a), ring_b = Neighbours(edge.b);
    if (!std::binary_search(ring_a.begin(), ring_a.end(), edge.b)) return false;
    std::vector<std::uint32_t> shared;
    std::set_intersection(ring_a.begin(), ring_a.end(), ring_b.begin(), ring_b.end(), std::back_inserter(shared));
    if (shared.size() != 2 || ring_a.size() + ring_b.size() > 32) return false;
    return Keeps(edge.a, edge.b, edge.p) && Keeps(edge.b, edge.a, edge.p);
  }

  bool Keeps(std::uint32_t moved, std::uint32_t other, const Vec& p) const {
    for (const std::uint32_t t : of_vertex_[moved]) {
      if (!alive_[t]) continue;
      const Triangle& triangle = triangles_[t];
      if (std::find(triangle.begin(), triangle.end(), other) != triangle.end()) continue;
      Vec corner[3];
      double longest = 0;
      for (std::size_t k = 0; k < 3; ++k) corner[k] = triangle[k] == moved ? p : p_[triangle[k]];
      for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, glm::length(corner[(k + 1) % 3] - corner[k]));
      const Vec before = Normal(triangle);
      const Vec after = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
      const double lengths = glm::length(before) * glm::length(after);
      if (!(glm::dot(before, after) > 0.2 * lengths)) return false;
      if (!(glm::length(after) > 0.02 * longest * longest)) return false;  // a sliver
    }
    return true;
  }

  void Collapse(const Candidate& edge) {
    p_[edge.a] = edge.p;
    quadric_[edge.a] = quadric_[edge.a] + quadric_[edge.b];
    for (const std::uint32_t t : of_vertex_[edge.b]) {
      if (!alive_[t]) continue;
      Triangle& triangle = triangles_[t];
      if (std::find(triangle.begin(), triangle.end(), edge.a) != triangle.end()) {
        alive_[t] = false;
        --count_;
      } else {
        std::replace(triangle.begin(), triangle.end(), edge.b, edge.a);
        of_vertex_[edge.a].push_back(t);
      }
    }
    of_vertex_[edge.b].clear();
    stamp_[edge.b] = kGone;
    std::erase_if(of_vertex_[edge.a], [&](std::uint32_t t) { return !alive_[t]; });
    ++stamp_[edge.a];
    for (const std::uint32_t v : Neighbours(edge.a)) Push(edge.a, v);
  }

  Mesh Compact() const {
    Mesh out;
    std::vector<std::uint32_t> number(p_.size(), kGone);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (!alive_[t]) continue;
      Triangle triangle = triangles_[t];
      for (std::uint32_t& v : triangle) {
        if (number[v] == kGone) {
          number[v] = static_cast<std::uint32_t>(out.positions.size());
          out.positions.push_back(p_[v]);
        }
        v = number[v];
      }
      out.triangles.push_back(triangle);
    }
    return out;
  }

  std::vector<Vec> p_;
  std::vector<Triangle> triangles_;
  std::vector<bool> alive_;
  std::vector<Quadric> quadric_;
  std::vector<std::uint32_t> stamp_;
  std::vector<std::vector<std::uint32_t>> of_vertex_;
  std::size_t count_;
  std::priority_queue<Candidate> heap_;
};

}  // namespace

Mesh Decimate(const Mesh& mesh, const std::vector<double>& importance, std::size_t triangles) {
  return Decimator(mesh, importance).Run(triangles);
}

}  // namespace omni::scenes
