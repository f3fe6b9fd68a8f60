// Plain vectors for the seams: trivially copyable, no alignment rules, so that they can live in shared memory, rings
// and hashes; and the few operations on them. Plain double arithmetic in a fixed order: with contraction off, equal
// inputs give equal bits. Physics code that needs matrices works in Eigen (see eigen.h) and converts at its boundary.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

namespace omni::base {

struct Vec3 {
  double x = 0;
  double y = 0;
  double z = 0;
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

// Unit quaternion, Hamilton convention, rotates from the named child frame to the parent frame.
struct Quat {
  double w = 1;
  double x = 0;
  double y = 0;
  double z = 0;
  friend bool operator==(const Quat&, const Quat&) = default;
};

static_assert(std::is_trivially_copyable_v<Vec3> && std::is_trivially_copyable_v<Quat>);

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator-(const Vec3& a) noexcept { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(double s, const Vec3& a) noexcept { return {s * a.x, s * a.y, s * a.z}; }
constexpr Vec3& operator+=(Vec3& a, const Vec3& b) noexcept { return a = a + b; }

constexpr Vec3 VecOf(const std::array<double, 3>& v) noexcept { return {v[0], v[1], v[2]}; }

constexpr double Dot(const Vec3& a, const Vec3& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 Cross(const Vec3& a, const Vec3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double SquaredNorm(const Vec3& a) noexcept { return Dot(a, a); }
inline double Norm(const Vec3& a) noexcept { return std::sqrt(SquaredNorm(a)); }
inline double Distance(const Vec3& a, const Vec3& b) noexcept { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

// a / |a|, zero for the zero vector.
inline Vec3 Normalized(const Vec3& a) noexcept {
  const double norm = Norm(a);
  return norm > 0 ? (1 / norm) * a : Vec3{};
}

// Component by component.
constexpr Vec3 Min(const Vec3& a, const Vec3& b) noexcept {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
constexpr Vec3 Max(const Vec3& a, const Vec3& b) noexcept {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

// True if every component is a number and |component| <= limit.
inline bool IsWithin(const Vec3& a, double limit) noexcept {
  return std::abs(a.x) <= limit && std::abs(a.y) <= limit && std::abs(a.z) <= limit;
}

// v' = v + 2 w (n x v) + 2 n x (n x v), n = (x, y, z) of the unit quaternion.
constexpr Vec3 Rotated(const Quat& rotation, const Vec3& v) noexcept {
  const Vec3 n{rotation.x, rotation.y, rotation.z};
  const Vec3 twice = 2.0 * Cross(n, v);
  return v + rotation.w * twice + Cross(n, twice);
}

}  // namespace omni::base
