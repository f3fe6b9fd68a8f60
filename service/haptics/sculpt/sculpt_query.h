// Questions to a sculpted surface: nearest point, first crossing of a segment, a feature found again after an edit. No
// allocation; stacks are fixed, because TopTree keeps kMaxTopDepth.
#pragma once

#include <limits>

#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics::sculpt {

struct SculptNearest {
  std::uint32_t triangle = kNoIndex;  // kNoIndex: nothing nearer than asked
  ClosestPoint closest;
};

// Nearest point of the surface to `p` that is nearer than `max_distance_m`. `facing`: zero, or a direction that the
// triangle's normal must not oppose.
SculptNearest NearestPoint(const SculptSurface& surface, const Vec3& p,
                           double max_distance_m = std::numeric_limits<double>::infinity(),
                           const Vec3& facing = {}) noexcept;

struct SculptCrossing {
  std::uint32_t triangle = kNoIndex;
  double t = 0;
};

// First triangle that the segment crosses from the front; components in skip[0..skip_count) do not count.
SculptCrossing FirstCrossing(const SculptSurface& surface, const Vec3& start, const Vec3& end,
                             const std::uint32_t* skip = nullptr, int skip_count = 0) noexcept;

// Where a point of an older generation is now: nearest point within `reach_m` that faces like `normal`, else nearest of
// any. A thin part does not turn the proxy over to its other side.   (6.2)
SculptNearest FindAgain(const SculptSurface& surface, const Vec3& point_base_m, const Vec3& normal,
                        double reach_m) noexcept;

}  // namespace omni::haptics::sculpt
