// Queries on a sculpted surface beyond those on any tree (query.h). No allocation.
#pragma once

#include <limits>

#include "service/haptics/geometry/query.h"
#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics {

extern template NearestResult NearestInTree(const sculpt::SculptSurface&, std::uint32_t, const Vec3&, double,
                                            std::uint32_t) noexcept;
extern template NearestResult NearestFaceInTree(const sculpt::SculptSurface&, std::uint32_t, const Vec3&, double,
                                                const FacesTowards&) noexcept;
extern template CrossingResult CrossingInTree(const sculpt::SculptSurface&, std::uint32_t, const Vec3&, const Vec3&,
                                              bool, const Skipped&) noexcept;
extern template double SideOf(const sculpt::SculptSurface&, const NearestResult&, const Vec3&) noexcept;

}  // namespace omni::haptics

namespace omni::haptics::sculpt {

// Where a point of an older generation is now: nearest point within `reach_m` that faces like `normal` (zero: any),
// else nearest of any. A thin part does not turn the proxy over to its other side.   (6.2)
NearestResult FindAgain(const SculptSurface& surface, const Vec3& point_base_m, const Vec3& normal,
                        double reach_m) noexcept;

}  // namespace omni::haptics::sculpt
