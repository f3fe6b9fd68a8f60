// Questions to the tree of one object: nearest point, first crossing of a segment. No allocation; stacks are fixed,
// because BuildScene guarantees kMaxBvhDepth.
#pragma once

#include <limits>

#include "service/haptics/geometry/surface.h"

namespace omni::haptics {

struct NearestResult {
  std::uint32_t triangle = kNoIndex;  // kNoIndex: nothing nearer than asked
  ClosestPoint closest;
};

// Nearest point of the object to `p` that is nearer than `max_distance_m`.
NearestResult NearestPoint(const Surface& surface, const Object& object, const Vec3& p,
                           double max_distance_m = std::numeric_limits<double>::infinity()) noexcept;

struct CrossingResult {
  std::uint32_t triangle = kNoIndex;
  bool front = true;
  double t = 0;
};

// First triangle that the segment crosses. `skip[0..skip_count)`: components that do not count. One-sided objects are
// entered from the front only, double-sided ones from both sides.
CrossingResult FirstCrossing(const Surface& surface, const Object& object, const Vec3& start, const Vec3& end,
                             const std::uint32_t* skip, int skip_count) noexcept;

// Distance from `p` to the object's box (0 inside): a lower bound of the distance to its surface.
double BoxDistance(const BvhNode& node, const Vec3& p) noexcept;

// +1: p in front of the nearest point, -1: behind it (inside a closed object).
double SideOf(const Surface& surface, const NearestResult& nearest, const Vec3& p) noexcept;

}  // namespace omni::haptics
