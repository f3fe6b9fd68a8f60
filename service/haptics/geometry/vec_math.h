// The few vector operations the renderer needs on base::Vec3. Plain double arithmetic in a fixed order: with
// contraction off, equal inputs give equal bits.
#pragma once

#include <algorithm>
#include <cmath>

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator-(const Vec3& a) noexcept { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(double s, const Vec3& a) noexcept { return {s * a.x, s * a.y, s * a.z}; }
constexpr double Dot(const Vec3& a, const Vec3& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 Cross(const Vec3& a, const Vec3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double SquaredNorm(const Vec3& a) noexcept { return Dot(a, a); }
inline double Norm(const Vec3& a) noexcept { return std::sqrt(SquaredNorm(a)); }

// a / |a|, zero for the zero vector.
inline Vec3 Normalized(const Vec3& a) noexcept {
  const double norm = Norm(a);
  return norm > 0 ? (1 / norm) * a : Vec3{};
}

constexpr Vec3 Min(const Vec3& a, const Vec3& b) noexcept {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
constexpr Vec3 Max(const Vec3& a, const Vec3& b) noexcept {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

// True if every component is a number and |component| <= limit.
inline bool Within(const Vec3& a, double limit) noexcept {
  return std::abs(a.x) <= limit && std::abs(a.y) <= limit && std::abs(a.z) <= limit;
}

}  // namespace omni::haptics
