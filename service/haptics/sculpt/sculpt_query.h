// Queries on a sculpted surface beyond those on any tree (query.h), and what becomes of a touch when a newer generation
// arrives under the pen. No allocation. docs/theory/sculpting.md, section 6.
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
extern template bool IsInsideByWinding(const sculpt::SculptSurface&, std::uint32_t, const Vec3&) noexcept;
extern template double SideOf(const sculpt::SculptSurface&, const NearestResult&, const Vec3&) noexcept;

}  // namespace omni::haptics

namespace omni::haptics::sculpt {

// Where a point of an older generation is now: nearest point within `reach_m` that faces like `normal` (zero: any),
// else nearest of any. A thin part does not turn the proxy over to its other side.   (6.2)
NearestResult FindAgain(const SculptSurface& surface, const Vec3& point_base_m, const Vec3& normal,
                        double reach_m) noexcept;

inline constexpr double kStill_m = 1e-6;  // the surface counts as unmoved under the contact

// A place on the surface as the tick keeps it: enough to find it again when its triangle is gone.
struct KeptFeature {
  std::uint32_t triangle = kNoIndex;  // kNoIndex: none
  std::array<double, 3> weights{};
  Vec3 point_base_m;
  Vec3 normal;  // unit, outwards
};

// Puts the feature on the newest surface. Returns how far it moved (m). The new place is the nearest point within
// `reach_m` facing the same way, else the nearest of all.   (6.2)
inline double RebindFeature(const SculptSurface& surface, double reach_m, KeptFeature& feature) noexcept {
  const NearestResult now = FindAgain(surface, feature.point_base_m, feature.normal, reach_m);
  if (now.triangle == kNoIndex) {
    feature = {};
    return 0;
  }
  const double moved_m = std::sqrt(now.closest.distance_squared);
  feature.triangle = now.triangle;
  feature.weights = now.closest.weights;
  feature.point_base_m = now.closest.point;
  feature.normal = Normalized(AreaVector(surface.TriangleCorners(now.triangle)));
  return moved_m;
}

}  // namespace omni::haptics::sculpt
