// The bodies of query.h's templates: include this where a view is instantiated, once per view.
#pragma once

#include <bit>

#include "service/haptics/geometry/query.h"
#include "service/haptics/geometry/topology.h"
#include "service/haptics/geometry/tree_lanes.h"

namespace omni::haptics {

// Children to visit, nearest on top. A key is the float distance squared (its bits order like the number, >= 0) over
// the child.
class NearestStack {
 public:
  bool empty() const noexcept { return size_ == 0; }
  std::uint64_t Pop() noexcept { return keys_[--size_]; }
  static float DistanceSquared(std::uint64_t key) noexcept {
    return std::bit_cast<float>(static_cast<std::uint32_t>(key >> 32));
  }
  static std::uint32_t Child(std::uint64_t key) noexcept { return static_cast<std::uint32_t>(key); }

  // Pushes the children within `bound_squared`, farthest first.
  void PushChildren(const TreeNode& node, const Lanes3& p, float bound_squared) noexcept {
    alignas(16) float distance[kTreeWidth];
    const __m128 bound = _mm_set1_ps(bound_squared);
    const __m128 low = BoxDistanceSquared(node, 0, p), high = BoxDistanceSquared(node, 1, p);
    _mm_store_ps(distance, low);
    _mm_store_ps(distance + 4, high);
    auto mask = static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(low, bound)) |
                                      _mm_movemask_ps(_mm_cmple_ps(high, bound)) << 4);
    const std::size_t first = size_;
    for (; mask != 0; mask &= mask - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(mask));
      const std::uint64_t key = std::uint64_t{std::bit_cast<std::uint32_t>(distance[k])} << 32 | node.child[k];
      std::size_t at = size_++;
      for (; at > first && keys_[at - 1] < key; --at) keys_[at] = keys_[at - 1];
      keys_[at] = key;
    }
  }

 private:
  std::array<std::uint64_t, (kTreeWidth - 1) * kMaxTreeDepth + kTreeWidth> keys_;
  std::size_t size_ = 0;
};

// Tries the leaf's triangles within `bound` (which trying lowers), the nearest first: it mostly excludes the others.
template <LeafRangeView View, class TryTriangle>
void NearestInLeaf(const View& view, const LeafRange& leaf, const Lanes3& p, const float& bound,
                   const TryTriangle& try_triangle) noexcept {
  alignas(16) float distance[kLeafSize] = {0, 0, 0, 0};
  unsigned mask = leaf.LaneMask();
  if (!leaf.moves) {
    const __m128 d = BoundTriangles(view.RestCorners(leaf), p).DistanceSquared();
    _mm_store_ps(distance, d);
    mask &= static_cast<unsigned>(_mm_movemask_ps(_mm_cmpngt_ps(d, _mm_set1_ps(bound))));
  }
  while (mask != 0) {
    auto k = static_cast<std::uint32_t>(std::countr_zero(mask));
    for (unsigned rest = mask & (mask - 1); rest != 0; rest &= rest - 1) {
      const auto other = static_cast<std::uint32_t>(std::countr_zero(rest));
      if (distance[other] < distance[k]) k = other;
    }
    mask &= ~(1U << k);
    if (!(distance[k] > bound)) try_triangle(leaf.first + k);
  }
}

// Branch and bound   (1.7) over the triangles that accept(triangle, closest point) lets count.
template <TreeView View, class Accept>
NearestResult NearestAccepted(const View& view, std::uint32_t root, const Vec3& p, double max_distance_m,
                              std::uint32_t known, const Accept& accept) noexcept {
  NearestResult best;
  best.closest.distance_squared = max_distance_m * max_distance_m;
  const double slack_m = FloatSlack(view.TreeExtent(), LargestComponent(p));
  float bound = SquaredBound(max_distance_m, slack_m);
  const auto try_triangle = [&](std::uint32_t triangle) noexcept {
    const ClosestPoint closest = ClosestOnTriangle(view.TriangleCorners(triangle), p);
    if (!(closest.distance_squared < best.closest.distance_squared) || !accept(triangle, closest)) return;
    best = {triangle, closest};
    bound = SquaredBound(std::sqrt(closest.distance_squared), slack_m);
  };
  const auto try_other = [&](std::uint32_t triangle) noexcept {
    if (triangle != known) try_triangle(triangle);
  };
  if (known != kNoIndex) try_triangle(known);
  const Lanes3 lanes = Broadcast(p);
  NearestStack stack;
  stack.PushChildren(view.Node(root), lanes, bound);
  while (!stack.empty()) {
    const std::uint64_t key = stack.Pop();
    if (!(NearestStack::DistanceSquared(key) <= bound)) continue;
    const std::uint32_t child = NearestStack::Child(key);
    if ((child & kLeafBit) == 0) {
      stack.PushChildren(view.Node(child), lanes, bound);
      continue;
    }
    if constexpr (LeafRangeView<View>) {
      NearestInLeaf(view, LeafRange::Of(child), lanes, bound, try_other);
    } else {
      std::array<std::uint32_t, kLeafSize> triangles;
      const int count = view.LeafTriangles(child & kChildIndex, triangles);
      for (int k = 0; k < count; ++k) try_other(triangles[static_cast<std::size_t>(k)]);
    }
  }
  return best;
}

template <TreeView View>
NearestResult NearestInTree(const View& view, std::uint32_t root, const Vec3& p, double max_distance_m,
                            std::uint32_t known) noexcept {
  return NearestAccepted(view, root, p, max_distance_m, known,
                         [](std::uint32_t, const ClosestPoint&) noexcept { return true; });
}

template <TreeView View>
NearestResult NearestFaceInTree(const View& view, std::uint32_t root, const Vec3& p, double max_distance_m,
                                const FacesTowards& faces) noexcept {
  constexpr double kAlong = 0.7;
  return NearestAccepted(view, root, p, max_distance_m, kNoIndex,
                         [&](std::uint32_t triangle, const ClosestPoint& closest) noexcept {
                           const Vec3 normal = FaceNormal(view, triangle);
                           return Dot(normal, faces.direction) >= faces.cosine &&
                                  Dot(closest.point - p, normal) >= kAlong * std::sqrt(closest.distance_squared);
                         });
}

inline bool IsSkipped(const Skipped& skip, std::uint32_t component) noexcept {
  for (int k = 0; k < skip.count; ++k) {
    if (skip.components[k] == component) return true;
  }
  return false;
}

// Calls meet(triangle, hit) for every triangle that the segment crosses.
template <TreeView View, class Meet>
void ForEachCrossing(const View& view, std::uint32_t root, const Vec3& start, const Vec3& end,
                     const Meet& meet) noexcept {
  const SegmentLanes segment(start, end, view.TreeExtent());
  const auto try_triangle = [&](std::uint32_t triangle) noexcept {
    const TriangleHit hit = IntersectTriangle(view.TriangleCorners(triangle), start, end);
    if (hit.hit) meet(triangle, hit);
  };
  std::array<std::uint32_t, (kTreeWidth - 1) * kMaxTreeDepth + kTreeWidth> stack;
  std::size_t size = 0;
  stack[size++] = root;
  while (size > 0) {
    const std::uint32_t child = stack[--size];
    if ((child & kLeafBit) == 0) {
      const TreeNode& node = view.Node(child);
      for (auto mask = static_cast<unsigned>(MeetMask(node, segment)); mask != 0; mask &= mask - 1) {
        stack[size++] = node.child[std::countr_zero(mask)];
      }
      continue;
    }
    if constexpr (LeafRangeView<View>) {
      const LeafRange leaf = LeafRange::Of(child);
      unsigned mask = leaf.LaneMask();
      if (!leaf.moves) mask &= static_cast<unsigned>(MeetMask(view.RestCorners(leaf), segment));
      for (; mask != 0; mask &= mask - 1) try_triangle(leaf.first + static_cast<std::uint32_t>(std::countr_zero(mask)));
    } else {
      std::array<std::uint32_t, kLeafSize> triangles;
      const int count = view.LeafTriangles(child & kChildIndex, triangles);
      for (int k = 0; k < count; ++k) try_triangle(triangles[static_cast<std::size_t>(k)]);
    }
  }
}

template <TreeView View>
CrossingResult CrossingInTree(const View& view, std::uint32_t root, const Vec3& start, const Vec3& end, bool both_sides,
                              const Skipped& skip) noexcept {
  CrossingResult best;
  best.t = 2;
  ForEachCrossing(view, root, start, end, [&](std::uint32_t triangle, const TriangleHit& hit) noexcept {
    if (!(hit.t < best.t) || (!both_sides && !hit.front)) return;
    if (IsSkipped(skip, view.GetTriangle(triangle).component)) return;
    best = {triangle, hit.front, hit.t};
  });
  return best;
}

// Directions spread evenly over the sphere (a Fibonacci lattice), of which none lies along an axis.
template <TreeView View>
bool IsInsideByWinding(const View& view, std::uint32_t root, const Vec3& p) noexcept {
  constexpr int kRays = 32, kNeeded = 22;  // 0.7: in a bowl it is less
  constexpr double kGoldenAngle = 2.399963229728653;
  const double length_m = 4 * (view.TreeExtent() + LargestComponent(p));
  int inside = 0;
  for (int k = 0; k < kRays && inside < kNeeded && inside + kRays - k >= kNeeded; ++k) {
    const double z = 1 - (2.0 * k + 1) / kRays, r = std::sqrt(1 - z * z), turn = kGoldenAngle * k + 0.1;
    int leaves = 0;
    ForEachCrossing(view, root, p, p + length_m * Vec3{r * std::cos(turn), r * std::sin(turn), z},
                    [&](std::uint32_t, const TriangleHit& hit) noexcept { leaves += hit.front ? -1 : 1; });
    inside += leaves > 0;
  }
  return inside >= kNeeded;
}

template <MeshView View>
double SideOf(const View& view, const NearestResult& nearest, const Vec3& p) noexcept {
  const Vec3 normal = Pseudonormal(view, nearest.triangle, nearest.closest.feature, nearest.closest.index);
  return Dot(p - nearest.closest.point, normal) >= 0 ? 1 : -1;
}

}  // namespace omni::haptics
