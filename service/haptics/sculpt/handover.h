// When a newer generation of the surface arrives under a touching pen: the features of the old one are found on the
// new. docs/theory/sculpting.md, section 6.
#pragma once

#include "service/haptics/sculpt/sculpt_query.h"

namespace omni::haptics::sculpt {

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
inline double Rebind(const SculptSurface& surface, double reach_m, KeptFeature& feature) noexcept {
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
