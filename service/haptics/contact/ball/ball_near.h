// What a ball can hit as it moves: all triangles near a place, and the first touch with one   (12.3), (12.6).
#pragma once

#include <bit>

#include "service/haptics/contact/ball/ball_proxy.h"
#include "service/haptics/geometry/query_in_tree.h"

namespace omni::haptics {

// A triangle near the ball, behind a plane: from a place displaced by `way` from where it was gathered, its distance is
// at least lower_m + normal . way   (12.3).
struct BallNeighbour {
  std::uint32_t triangle;
  std::array<float, 3> normal;
  double lower_m;

  double AtLeast(const Vec3& way) const noexcept {
    return lower_m + double{normal[0]} * way.x + double{normal[1]} * way.y + double{normal[2]} * way.z;
  }
};

// All triangles within some distance of a place.
struct BallNear {
  std::size_t count = 0;
  std::array<BallNeighbour, kMaxBallNear> of;
};

// Triangles of the leaf within `bound` (squared) of p. False: there is no room for all.
template <LeafRangeView View>
bool AddRange(const View& view, const LeafRange& leaf, const Lanes3& p, float bound, double slack_m,
              BallNear& near) noexcept {
  alignas(16) float squared[kLeafSize] = {}, normal[3][kLeafSize] = {};
  unsigned mask = leaf.LaneMask();
  if (!leaf.moves) {
    const TriangleBounds bounds = BoundTriangles(view.RestCorners(leaf), p);
    const __m128 d = bounds.DistanceSquared();
    mask &= static_cast<unsigned>(_mm_movemask_ps(_mm_cmpngt_ps(d, _mm_set1_ps(bound))));
    if (mask == 0) return true;
    const __m128 back = _mm_div_ps(_mm_set1_ps(-1), _mm_sqrt_ps(bounds.length_squared));
    _mm_store_ps(squared, d);
    _mm_store_ps(normal[0], _mm_mul_ps(back, bounds.to_nearest.x));
    _mm_store_ps(normal[1], _mm_mul_ps(back, bounds.to_nearest.y));
    _mm_store_ps(normal[2], _mm_mul_ps(back, bounds.to_nearest.z));
  }
  for (; mask != 0; mask &= mask - 1) {
    const auto k = static_cast<std::uint32_t>(std::countr_zero(mask));
    if (near.count == kMaxBallNear) return false;
    BallNeighbour& added = near.of[near.count++];
    added = {leaf.first + k, {}, 0};
    if (!(squared[k] > 0)) continue;  // nothing is known
    added.normal = {normal[0][k], normal[1][k], normal[2][k]};
    added.lower_m = std::sqrt(double{squared[k]}) * (1 - 0x1p-20) - slack_m;
  }
  return true;
}

// The same for a leaf that is a list, in double.
template <LeafListView View>
bool AddList(const View& view, std::uint32_t leaf, const Vec3& p, double distance_m, double slack_m,
             BallNear& near) noexcept {
  std::array<std::uint32_t, kLeafSize> triangles;
  const int count = view.LeafTriangles(leaf, triangles);
  for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
    const ClosestPoint closest = ClosestOnTriangle(view.TriangleCorners(triangles[k]), p);
    const double away_m = std::sqrt(closest.distance_squared);
    if (away_m > distance_m) continue;
    if (near.count == kMaxBallNear) return false;
    BallNeighbour& added = near.of[near.count++];
    added = {triangles[k], {}, 0};
    if (!(away_m > slack_m)) continue;
    const Vec3 normal = (1 / away_m) * (p - closest.point);
    added.normal = {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)};
    added.lower_m = away_m * (1 - 0x1p-20) - slack_m;
  }
  return true;
}

// False: more than kMaxBallNear.
template <TreeView View>
bool GatherNear(const View& view, std::uint32_t root, const Vec3& p, double distance_m, BallNear& near) noexcept {
  near.count = 0;
  const double slack_m = FloatSlack(view.TreeExtent(), LargestComponent(p));
  const float bound = SquaredBound(distance_m, slack_m);
  const __m128 bound_lanes = _mm_set1_ps(bound);
  const Lanes3 lanes = Broadcast(p);
  std::array<std::uint32_t, (kTreeWidth - 1) * kMaxTreeDepth + kTreeWidth> stack;
  std::size_t size = 0;
  stack[size++] = root;
  while (size > 0) {
    const std::uint32_t child = stack[--size];
    if ((child & kLeafBit) != 0) {
      if constexpr (LeafRangeView<View>) {
        if (!AddRange(view, LeafRange::Of(child), lanes, bound, slack_m, near)) return false;
      } else {
        if (!AddList(view, child & kChildIndex, p, distance_m, slack_m, near)) return false;
      }
      continue;
    }
    const TreeNode& node = view.Node(child);
    const auto low = _mm_movemask_ps(_mm_cmple_ps(BoxDistanceSquared(node, 0, lanes), bound_lanes));
    const auto high = _mm_movemask_ps(_mm_cmple_ps(BoxDistanceSquared(node, 1, lanes), bound_lanes));
    for (auto mask = static_cast<unsigned>(low | high << 4); mask != 0; mask &= mask - 1) {
      stack[size++] = node.child[std::countr_zero(mask)];
    }
  }
  return true;
}

// (12.3) First t in [0, limit] at which a ball moving from `centre` by t `move` is as near as `radius_m` to the
// triangle and comes nearer; `limit` if none. The distance is convex in t, so Newton's steps never pass the first
// touch: wherever they end, the path so far is free.
inline double FirstTouch(const Corners& corners, const Vec3& centre, const Vec3& move, double radius_m, double near_m,
                         double limit) noexcept {
  constexpr int kMaxNewton = 32;
  double t = 0;
  for (int k = 0; k < kMaxNewton; ++k) {
    const Vec3 at = centre + t * move;
    const ClosestPoint closest = ClosestOnTriangle(corners, at);
    const double distance_m = std::sqrt(closest.distance_squared), gap_m = distance_m - radius_m;
    const double approach = distance_m > 0 ? -Dot(at - closest.point, move) / distance_m : 0;
    if (gap_m <= near_m) return approach > 1e-9 * Norm(move) ? t : limit;
    if (!(approach * (limit - t) > gap_m)) return limit;
    t += gap_m / approach;
  }
  return t;
}

}  // namespace omni::haptics
