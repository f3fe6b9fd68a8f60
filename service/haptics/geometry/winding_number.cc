#include "service/haptics/geometry/winding_number.h"

#include <algorithm>
#include <numbers>
#include <numeric>

namespace omni::haptics {
namespace {

constexpr std::uint32_t kLeafTriangles = 8;
constexpr double kFar = 2.5;  // a cluster is one dipole from this many radii on

}  // namespace

// tan(omega / 2) = a.(b x c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)   (R.4) [van Oosterom & Strackee 1983]
double SolidAngle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = Norm(a), lb = Norm(b), lc = Norm(c);
  return 2 * std::atan2(Dot(a, Cross(b, c)), la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb);
}

WindingTree::WindingTree(std::span<const Vec3> vertices, Triangles triangles, const base::WorkWatch& watch)
    : vertices_(vertices), triangles_(triangles), order_(triangles.size()) {
  if (order_.empty()) return;
  std::iota(order_.begin(), order_.end(), 0U);
  {
    std::vector<Vec3> centroids(order_.size());
    for (std::size_t t = 0; t < centroids.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      centroids[t] = (1.0 / 3) * (vertices[a] + vertices[b] + vertices[c]);
    }
    nodes_.reserve(centroids.size() / 3 + 8);
    Build(0, static_cast<std::uint32_t>(order_.size()), centroids, watch);
  }
  corners_.resize(order_.size());
  Refit();
}

// Halves along the longest axis: the depth is log2(n / 8), so recursion is shallow.
std::uint32_t WindingTree::Build(std::uint32_t first, std::uint32_t count, const std::vector<Vec3>& centroids,
                                 const base::WorkWatch& watch) {
  watch.Did(1 + count / 16);  // tens of nanoseconds each
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[index].first = first;
  nodes_[index].count = count;
  if (count <= kLeafTriangles) return index;
  Vec3 lower = centroids[order_[first]], upper = lower;
  for (std::uint32_t i = first; i < first + count; ++i) {
    lower = Min(lower, centroids[order_[i]]);
    upper = Max(upper, centroids[order_[i]]);
  }
  const Vec3 d = upper - lower;
  double Vec3::*axis = d.x >= d.y && d.x >= d.z ? &Vec3::x : (d.y >= d.z ? &Vec3::y : &Vec3::z);
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    return centroids[a].*axis != centroids[b].*axis ? centroids[a].*axis < centroids[b].*axis : a < b;
  });
  const std::uint32_t left = Build(first, count / 2, centroids, watch);
  const std::uint32_t right = Build(first + count / 2, count - count / 2, centroids, watch);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return index;
}

void WindingTree::FitLeaf(Node& node) const {
  node.area_m2 = 0;
  node.centre = node.area_vector = {};
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const auto& [a, b, c] = corners_[i];
    const Vec3 vector = 0.5 * Cross(b - a, c - a);
    const double weight = Norm(vector);
    node.area_vector = node.area_vector + vector;
    node.centre = node.centre + (weight / 3) * (a + b + c);
    node.area_m2 += weight;
  }
  node.centre = node.area_m2 > 0 ? (1 / node.area_m2) * node.centre : corners_[node.first][0];
  node.radius_m = 0;
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    for (const Vec3& v : corners_[i]) node.radius_m = std::max(node.radius_m, Norm(v - node.centre));
  }
}

void WindingTree::Refit() {
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const auto& [a, b, c] = triangles_[order_[i]];
    corners_[i] = {vertices_[a], vertices_[b], vertices_[c]};
  }
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {  // children come after their parent
    if (node->left == 0) {
      FitLeaf(*node);
      continue;
    }
    const Node &left = nodes_[node->left], &right = nodes_[node->right];
    node->area_vector = left.area_vector + right.area_vector;
    node->area_m2 = left.area_m2 + right.area_m2;
    const double share = node->area_m2 > 0 ? left.area_m2 / node->area_m2 : 0.5;
    node->centre = share * left.centre + (1 - share) * right.centre;
    node->radius_m =
        std::max(Norm(left.centre - node->centre) + left.radius_m, Norm(right.centre - node->centre) + right.radius_m);
  }
}

// w(p) = 1/(4 pi) sum of solid angles; a far cluster adds A . r / (4 pi |r|^3), r = centre - p   (R.5)
double WindingTree::At(const Vec3& p, std::uint32_t own, std::uint64_t& visited) const {
  if (nodes_.empty()) return 0;
  std::array<std::uint32_t, 64> stack{};
  std::size_t size = 1;
  double sum = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    const Vec3 r = node.centre - p;
    const double distance = Norm(r);
    ++visited;
    if (distance > kFar * node.radius_m) {
      sum += Dot(node.area_vector, r) / (distance * distance * distance);
    } else if (node.left == 0) {
      visited += 2 * node.count;
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        if (order_[i] == own) continue;
        const auto& [a, b, c] = corners_[i];
        sum += SolidAngle(a - p, b - p, c - p);
      }
    } else {
      stack[size++] = node.left;
      stack[size++] = node.right;
    }
  }
  return sum / (4 * std::numbers::pi);
}

}  // namespace omni::haptics
