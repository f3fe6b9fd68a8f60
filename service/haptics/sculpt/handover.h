// When a newer generation of the surface arrives under a touching pen: the features of the old one are found on the
// new, and the force goes over smoothly. docs/theory/sculpting.md, section 6.
#pragma once

#include "service/haptics/sculpt/sculpt_query.h"

namespace omni::haptics::sculpt {

inline constexpr double kFade_s = 0.02;
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

// From the force before to the force after, over kFade_s. Starting again while it runs goes on from the present force.
class ForceFade {
 public:
  void Start() noexcept {
    from_N_ = last_N_;
    left_s_ = kFade_s;
  }
  // F = s F_old + (1 - s) F_new, s falling from 1 to 0   (6.1)
  Vec3 Blend(const Vec3& now_N, double dt_s) noexcept {
    left_s_ = std::max(0.0, left_s_ - dt_s);
    const double old_share = left_s_ / kFade_s;
    last_N_ = old_share > 0 ? old_share * from_N_ + (1 - old_share) * now_N : now_N;
    return last_N_;
  }

 private:
  Vec3 from_N_, last_N_;
  double left_s_ = 0;
};
static_assert(std::is_trivially_copyable_v<ForceFade>);

}  // namespace omni::haptics::sculpt
