// Ground truth by brute force: nearest point over all triangles, winding number.
#pragma once

#include <vector>

#include "service/haptics/geometry/query.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {

inline NearestResult BruteNearest(const Scene& scene, const Surface& surface, const Vec3& p) {
  NearestResult best;
  best.closest.distance_squared = 1e30;
  for (std::uint32_t t = 0; t < scene.header().triangle_count; ++t) {
    const ClosestPoint closest = ClosestOnTriangle(surface.TriangleCorners(t), p);
    if (closest.distance_squared < best.closest.distance_squared) best = {t, closest};
  }
  return best;
}

// Sum of solid angles over 4 pi   [van Oosterom & Strackee 1983]: 1 inside, 0 outside.
inline double WindingNumber(const Scene& scene, const Surface& surface, const Vec3& p) {
  double sum = 0;
  for (std::uint32_t t = 0; t < scene.header().triangle_count; ++t) {
    const Corners corners = surface.TriangleCorners(t);
    const Vec3 a = corners[0] - p, b = corners[1] - p, c = corners[2] - p;
    const double la = Norm(a), lb = Norm(b), lc = Norm(c);
    sum += std::atan2(Dot(a, Cross(b, c)), la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

}  // namespace omni::haptics
