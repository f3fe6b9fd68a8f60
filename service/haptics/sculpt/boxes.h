// Arithmetic on eight boxes at a time. Boxes are float, questions are double: a box test never loses what is inside.
#pragma once

#include <array>
#include <cmath>
#include <cstring>

#include "service/haptics/sculpt/page.h"

namespace omni::haptics::sculpt {

// Box of float corners; empty: lower > upper.
struct FloatBox {
  std::array<float, 3> lower{kNoBox, kNoBox, kNoBox};
  std::array<float, 3> upper{-kNoBox, -kNoBox, -kNoBox};
  bool empty() const noexcept { return !(lower[0] <= upper[0]); }
  void Add(const FloatBox& other) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], other.lower[axis]);
      upper[axis] = std::max(upper[axis], other.upper[axis]);
    }
  }
  friend bool operator==(const FloatBox&, const FloatBox&) = default;
};

// Nearest floats are within 2^-24 |x| of x; one step of 2^-23 |x| outwards is at least one float further.
inline float BelowFloat(double x) noexcept {
  const auto f = static_cast<float>(x);
  return f - std::abs(f) * 0x1p-23F - 1e-36F;
}
inline float AboveFloat(double x) noexcept {
  const auto f = static_cast<float>(x);
  return f + std::abs(f) * 0x1p-23F + 1e-36F;
}

inline FloatBox BoxOf(const Corners& c) noexcept {
  const Vec3 lower = Min(Min(c[0], c[1]), c[2]);
  const Vec3 upper = Max(Max(c[0], c[1]), c[2]);
  return {{BelowFloat(lower.x), BelowFloat(lower.y), BelowFloat(lower.z)},
          {AboveFloat(upper.x), AboveFloat(upper.y), AboveFloat(upper.z)}};
}

inline FloatBox GetBox(const Boxes8& boxes, std::size_t k) noexcept {
  return {{boxes.lower[0][k], boxes.lower[1][k], boxes.lower[2][k]},
          {boxes.upper[0][k], boxes.upper[1][k], boxes.upper[2][k]}};
}

inline void SetBox(const FloatBox& box, std::size_t k, Boxes8& boxes) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    boxes.lower[axis][k] = box.lower[axis];
    boxes.upper[axis][k] = box.upper[axis];
  }
}

inline FloatBox UnionOf(const Boxes8& boxes) noexcept {
  FloatBox all;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < 8; ++k) {
      all.lower[axis] = std::min(all.lower[axis], boxes.lower[axis][k]);
      all.upper[axis] = std::max(all.upper[axis], boxes.upper[axis][k]);
    }
  }
  return all;
}

// Squared distance from a point to each of eight boxes, 0 inside; never more than it is. In float: the point is rounded
// by at most 2^-24 of its largest coordinate, which each side is given as slack, and the rest of the rounding, under
// 2^-20, is taken off the sum.
class PointTest {
 public:
  explicit PointTest(const Vec3& p) noexcept
      : point_{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)},
        slack_(static_cast<float>(0x1p-23 * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}))) {}

  std::array<float, 8> DistancesSquared(const Boxes8& boxes) const noexcept {
    std::array<float, 8> result;
    for (std::size_t half = 0; half < 8; half += 4) {
      Four sum{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Four lower, upper;
        std::memcpy(&lower, &boxes.lower[axis][half], sizeof(Four));
        std::memcpy(&upper, &boxes.upper[axis][half], sizeof(Four));
        const Four below = lower - point_[axis], above = point_[axis] - upper;
        const Four outside = (below > above ? below : above) - slack_;
        const Four distance = outside > 0 ? outside : Four{};
        sum += distance * distance;
      }
      sum *= 1 - 0x1p-20F;
      std::memcpy(&result[half], &sum, sizeof(Four));
    }
    return result;
  }

 private:
  using Four = float __attribute__((vector_size(16)));  // SSE2 is in the baseline
  std::array<float, 3> point_;
  float slack_;
};

// Separating axes of a segment and a box   [Ericson, Real-Time Collision Detection, 5.3.3]
class SegmentTest {
 public:
  SegmentTest(const Vec3& start, const Vec3& end) noexcept
      : middle_(0.5 * (start + end)),
        half_(0.5 * (end - start)),
        abs_half_{std::abs(half_.x), std::abs(half_.y), std::abs(half_.z)} {}

  bool Misses(const Boxes8& boxes, std::size_t k) const noexcept {
    constexpr double kSlack_m = 1e-9;
    const double lx = boxes.lower[0][k], ly = boxes.lower[1][k], lz = boxes.lower[2][k];
    const double ux = boxes.upper[0][k], uy = boxes.upper[1][k], uz = boxes.upper[2][k];
    const Vec3 m{middle_.x - 0.5 * (lx + ux), middle_.y - 0.5 * (ly + uy), middle_.z - 0.5 * (lz + uz)};
    const Vec3 e{0.5 * (ux - lx) + kSlack_m, 0.5 * (uy - ly) + kSlack_m, 0.5 * (uz - lz) + kSlack_m};
    if (std::abs(m.x) > e.x + abs_half_.x) return true;
    if (std::abs(m.y) > e.y + abs_half_.y) return true;
    if (std::abs(m.z) > e.z + abs_half_.z) return true;
    const Vec3 a{abs_half_.x + kSlack_m, abs_half_.y + kSlack_m, abs_half_.z + kSlack_m};
    if (std::abs(m.y * half_.z - m.z * half_.y) > e.y * a.z + e.z * a.y) return true;
    if (std::abs(m.z * half_.x - m.x * half_.z) > e.x * a.z + e.z * a.x) return true;
    return std::abs(m.x * half_.y - m.y * half_.x) > e.x * a.y + e.y * a.x;
  }

 private:
  Vec3 middle_, half_, abs_half_;
};

}  // namespace omni::haptics::sculpt
