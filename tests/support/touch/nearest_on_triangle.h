// Nearest point of a triangle by a formula of its own: it judges the renderer's.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "service/base/vec.h"

namespace omni::support {

inline base::Vec3 NearestOnSegment(const base::Vec3& a, const base::Vec3& b, const base::Vec3& p) {
  const base::Vec3 ab = b - a;
  const double length_squared = Dot(ab, ab);
  const double t = length_squared > 0 ? std::clamp(Dot(p - a, ab) / length_squared, 0.0, 1.0) : 0;
  return a + t * ab;
}

// The foot on the plane if it lies within all three edges, else the nearest of the three segments.
inline base::Vec3 NearestOnTriangle(const std::array<base::Vec3, 3>& c, const base::Vec3& p) {
  const base::Vec3 normal = Cross(c[1] - c[0], c[2] - c[0]);
  const double square = Dot(normal, normal);
  bool within = square > 0;
  for (std::size_t k = 0; k < 3; ++k) {
    within = within && Dot(Cross(normal, c[(k + 1) % 3] - c[k]), p - c[k]) >= 0;
  }
  if (within) return p - (Dot(p - c[0], normal) / square) * normal;
  base::Vec3 best = NearestOnSegment(c[0], c[1], p);
  for (std::size_t k = 1; k < 3; ++k) {
    const base::Vec3 q = NearestOnSegment(c[k], c[(k + 1) % 3], p);
    if (Dot(p - q, p - q) < Dot(p - best, p - best)) best = q;
  }
  return best;
}

}  // namespace omni::support
