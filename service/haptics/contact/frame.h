// Where a moving object stands: from the frame its mesh rests in to the base frame and back. Runs in the tick.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/geometry/vec_math.h"

namespace omni::haptics {

// v' = v + 2 w (q x v) + 2 q x (q x v), q = (x, y, z) of the unit quaternion.
inline Vec3 Rotated(const base::Quat& rotation, const Vec3& v) noexcept {
  const Vec3 q{rotation.x, rotation.y, rotation.z};
  const Vec3 twice = 2.0 * Cross(q, v);
  return v + rotation.w * twice + Cross(q, twice);
}

// x = R p + t
struct Frame {
  bool at_rest = true;  // the rest is not looked at
  base::Quat rotation;
  Vec3 translation_m;

  Vec3 ToBase(const Vec3& p) const noexcept { return at_rest ? p : Rotated(rotation, p) + translation_m; }
  Vec3 ToRest(const Vec3& x) const noexcept { return at_rest ? x : RestDirection(x - translation_m); }
  Vec3 BaseDirection(const Vec3& v) const noexcept { return at_rest ? v : Rotated(rotation, v); }
  Vec3 RestDirection(const Vec3& v) const noexcept {
    return at_rest ? v : Rotated({rotation.w, -rotation.x, -rotation.y, -rotation.z}, v);
  }
};

}  // namespace omni::haptics
