// The proxy: a point on the surface that follows the device point by local descent and never loses contact by itself.
// docs/theory/haptics.md, section 2.
#pragma once

#include "service/haptics/geometry/surface.h"

namespace omni::haptics {

inline constexpr int kMaxMoves = 64;  // triangles the proxy may cross in a tick; it goes on in the next

struct ProxyPoint {
  std::uint32_t triangle = kNoIndex;
  ClosestPoint closest;
  Vec3 normal;  // pseudonormal at the proxy, out of the surface whatever the side
};

// Moves from `start_triangle` to a local minimum of the distance to `target` over the surface.
ProxyPoint Descend(const Surface& surface, std::uint32_t start_triangle, const Vec3& target) noexcept;

enum class ProxyVerdict { kInside, kOutside, kOverBorder };

// Is the tip still behind the surface at its proxy? `side` +1: front is outside, -1: entered from the back.
ProxyVerdict Judge(const Surface& surface, const ProxyPoint& proxy, const Vec3& tip, double side) noexcept;

}  // namespace omni::haptics
