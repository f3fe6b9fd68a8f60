// The few vector operations the twin needs, on the seam type itself.
#pragma once

#include <array>
#include <cmath>

#include "service/base/vec.h"

namespace omni::sim {

using base::Vec3;

inline constexpr std::array<Vec3, 3> kUnits{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

inline Vec3 operator+(const Vec3& a, const Vec3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) noexcept { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, const Vec3& a) noexcept { return {s * a.x, s * a.y, s * a.z}; }
inline Vec3& operator+=(Vec3& a, const Vec3& b) noexcept { return a = a + b; }
inline double Dot(const Vec3& a, const Vec3& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 Cross(const Vec3& a, const Vec3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double Norm(const Vec3& a) noexcept { return std::sqrt(Dot(a, a)); }
// Precondition: |a| > 0.
inline Vec3 Normalised(const Vec3& a) noexcept { return (1.0 / Norm(a)) * a; }

// Any unit vector perpendicular to the unit vector `a`.
inline Vec3 Perpendicular(const Vec3& a) noexcept {
  const Vec3 other = std::abs(a.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  return Normalised(Cross(a, other));
}

// v turned by the rotation vector w (axis times angle) [Rodrigues].
inline Vec3 Rotated(const Vec3& v, const Vec3& w) noexcept {
  const double angle = Norm(w);
  if (angle == 0) return v;
  const Vec3 n = (1.0 / angle) * w;
  return std::cos(angle) * v + std::sin(angle) * Cross(n, v) + ((1 - std::cos(angle)) * Dot(n, v)) * n;
}

// R(q) v for a unit quaternion.
inline Vec3 Rotated(const Vec3& v, const base::Quat& q) noexcept {
  const Vec3 n{q.x, q.y, q.z};
  const Vec3 t = 2.0 * Cross(n, v);
  return v + q.w * t + Cross(n, t);
}

}  // namespace omni::sim
