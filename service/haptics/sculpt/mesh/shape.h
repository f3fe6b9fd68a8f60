// What a triangle must keep: area, and the side it faces.
#pragma once

#include "service/haptics/geometry/triangle_math.h"

namespace omni::haptics::sculpt {

inline constexpr double kLeastShape = 1e-3;  // 2 area / longest edge^2; worse triangles are not made   (4.1)

inline double LongestSquared(const Corners& c) noexcept {
  return std::max({SquaredNorm(c[1] - c[0]), SquaredNorm(c[2] - c[1]), SquaredNorm(c[0] - c[2])});
}

// 2 area / longest edge^2: 0.87 equilateral, 0 without area. Not a number for a triangle that is a point.
inline double ShapeOf(const Corners& c) noexcept { return Norm(AreaVector(c)) / LongestSquared(c); }

// May `before` become `after`? It must keep facing the same way (cosine over `least_cosine` >= 0) and not become a
// needle, unless it was a worse one.
inline bool MayBecome(const Corners& before, const Corners& after, double least_cosine) noexcept {
  const Vec3 old_area = AreaVector(before), new_area = AreaVector(after);
  const double along = Dot(old_area, new_area);
  const double old2 = SquaredNorm(old_area), new2 = SquaredNorm(new_area);
  if (!(along > 0 && along * along > least_cosine * least_cosine * old2 * new2)) return false;
  const double longest2 = LongestSquared(after);
  return new2 >= kLeastShape * kLeastShape * longest2 * longest2 || ShapeOf(after) >= ShapeOf(before);
}

}  // namespace omni::haptics::sculpt
