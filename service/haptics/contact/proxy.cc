#include "service/haptics/contact/proxy.h"

#include "service/haptics/geometry/topology.h"

namespace omni::haptics {
namespace {

struct Candidate {
  std::uint32_t triangle = kNoIndex;
  ClosestPoint closest;
};

void Consider(const Surface& surface, std::uint32_t triangle, const Vec3& target, Candidate& best) noexcept {
  if (triangle == kNoIndex) return;
  const ClosestPoint closest = ClosestOnTriangle(surface.TriangleCorners(triangle), target);
  if (closest.distance_squared < best.closest.distance_squared) best = {triangle, closest};
}

}  // namespace

// Only what touches the feature the closest point lies on may take over: across the edge, or around the vertex. Looking
// farther would jump over creases by one triangle size and make the force depend on the tessellation.
ProxyPoint Descend(const Surface& surface, std::uint32_t start_triangle, const Vec3& target) noexcept {
  Candidate best{start_triangle, ClosestOnTriangle(surface.TriangleCorners(start_triangle), target)};
  for (int move = 0; move < kMaxMoves; ++move) {
    const Candidate from = best;
    const Triangle& t = surface.GetTriangle(from.triangle);
    if (from.closest.feature == Feature::kFace) break;
    if (from.closest.feature == Feature::kEdge) {
      Consider(surface, t.neighbour[from.closest.index], target, best);
    } else {
      WalkRing(surface, from.triangle, t.vertex[from.closest.index],
               [&](std::uint32_t fan, int) noexcept { Consider(surface, fan, target, best); });
    }
    if (best.triangle == from.triangle) break;
  }
  return {best.triangle, best.closest, Pseudonormal(surface, best.triangle, best.closest.feature, best.closest.index)};
}

ProxyVerdict Judge(const Surface& surface, const ProxyPoint& proxy, const Vec3& tip, double side) noexcept {
  const Vec3 offset = tip - proxy.closest.point;
  if (proxy.closest.feature == Feature::kFace) {  // the very predicate by which a sweep decides
    const Corners corners = surface.TriangleCorners(proxy.triangle);
    return side * Height(corners, AreaVector(corners), tip) > 0 ? ProxyVerdict::kOutside : ProxyVerdict::kInside;
  }
  const double height = side * Dot(offset, proxy.normal);
  if (height > 0 || (height == 0 && proxy.closest.distance_squared > 0)) return ProxyVerdict::kOutside;
  if (OnBorder(surface, proxy.triangle, proxy.closest.feature, proxy.closest.index)) {
    // Beyond the border: the tip is off to the side of the proxy, not straight behind it.
    const Vec3 sideways = offset - (side * height) * proxy.normal;
    if (SquaredNorm(sideways) > 1e-12 * proxy.closest.distance_squared + 1e-18) return ProxyVerdict::kOverBorder;
  }
  return ProxyVerdict::kInside;
}

}  // namespace omni::haptics
