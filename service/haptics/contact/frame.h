// Pose of a moving object: from its mesh's rest frame to the base frame and back. Runs in the tick.
#pragma once

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

// x = R p + t
struct Frame {
  bool at_rest = true;  // the other members are ignored
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
