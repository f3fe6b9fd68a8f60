// What the twin needs of vectors beyond service/base/vec.h, and constants.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "service/base/vec.h"

namespace omni::sim {

using base::Vec3;

inline constexpr std::array<Vec3, 3> kUnits{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

// Any unit vector perpendicular to the unit vector `a`.
inline Vec3 Perpendicular(const Vec3& a) noexcept {
  const Vec3 other = std::abs(a.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return Normalized(Cross(a, other));
}

// v turned by the rotation vector w (axis times angle) [Rodrigues].
inline Vec3 Rotated(const Vec3& v, const Vec3& w) noexcept {
  const double angle = Norm(w);
  if (angle == 0) return v;
  const Vec3 n = (1.0 / angle) * w;
  return std::cos(angle) * v + std::sin(angle) * Cross(n, v) + ((1 - std::cos(angle)) * Dot(n, v)) * n;
}

inline constexpr double kMu0 = 4e-7 * std::numbers::pi;  // permeability of vacuum, T m/A
inline constexpr double kMu0Over4Pi = 1e-7;

}  // namespace omni::sim
