// Boxes of a node, one at a time; rounded outwards, so that a box test never loses what is inside.
#pragma once

#include <array>
#include <cmath>

#include "service/haptics/sculpt/mesh/page.h"

namespace omni::haptics::sculpt {

inline constexpr float kNoBox = 1e30F;  // lower; upper = -kNoBox: nothing is near it, no segment meets it

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

inline FloatBox GetBox(const TreeNode& boxes, std::size_t k) noexcept {
  return {{boxes.lower[0][k], boxes.lower[1][k], boxes.lower[2][k]},
          {boxes.upper[0][k], boxes.upper[1][k], boxes.upper[2][k]}};
}

inline void SetBox(const FloatBox& box, std::size_t k, TreeNode& boxes) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    boxes.lower[axis][k] = box.lower[axis];
    boxes.upper[axis][k] = box.upper[axis];
  }
}

inline FloatBox UnionOf(const TreeNode& boxes) noexcept {
  FloatBox all;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < 8; ++k) {
      all.lower[axis] = std::min(all.lower[axis], boxes.lower[axis][k]);
      all.upper[axis] = std::max(all.upper[axis], boxes.upper[axis][k]);
    }
  }
  return all;
}

}  // namespace omni::haptics::sculpt
