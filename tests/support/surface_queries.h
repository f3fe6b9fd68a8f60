// Nearest point and first crossing of one object of a surface.
#pragma once

#include "service/haptics/geometry/query.h"

namespace omni::support {

inline haptics::NearestResult NearestPoint(const haptics::Surface& surface, const haptics::Object& object,
                                           const base::Vec3& p,
                                           double max_distance_m = std::numeric_limits<double>::infinity(),
                                           std::uint32_t known = haptics::kNoIndex) noexcept {
  return NearestInTree(surface, object.root, p, max_distance_m, known);
}

// One-sided objects are entered from the front only, double-sided ones from both sides.
inline haptics::CrossingResult FirstCrossing(const haptics::Surface& surface, const haptics::Object& object,
                                             const base::Vec3& start, const base::Vec3& end) noexcept {
  return CrossingInTree(surface, object.root, start, end, (object.flags & haptics::kDoubleSided) != 0);
}

}  // namespace omni::support
