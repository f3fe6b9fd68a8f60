// The point of an intersection of half-spaces that is nearest to a goal: where a ball held back by up to sixteen
// surfaces may go. docs/theory/haptics.md (12.4)
#pragma once

#include <array>
#include <span>

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

struct HalfSpace {
  Vec3 normal;        // unit; no two of a set within 1e-5 rad of each other
  double offset = 0;  // points p with normal . p >= offset, m
};

inline constexpr int kMaxActive = 3;

struct NearestInside {
  bool feasible = true;  // false: the half-spaces have no common point; `point` is then meaningless
  Vec3 point;
  int active_count = 0;  // planes that `point` was put on; 0: the goal itself is inside
  std::array<int, kMaxActive> active{};
};

// Exact but for rounding: a plane may be passed by `tolerance` (m, > 0), far below any length that matters.
NearestInside NearestInHalfSpaces(const Vec3& goal, std::span<const HalfSpace> spaces, double tolerance) noexcept;

// Multipliers m >= 0 of the planes in `inside` so that sum m_k normal_k is the push that holds the goal back: exactly
// point - goal for the nearest point, else its least-squares fit. Others are 0.
std::array<double, kMaxActive> Multipliers(const NearestInside& inside, std::span<const HalfSpace> spaces,
                                           const Vec3& push) noexcept;

}  // namespace omni::haptics
