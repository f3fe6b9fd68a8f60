#pragma once
// The two views of the one display.

#include <openxr/openxr.h>

#include "tests/runtime/spaces/motion.h"

namespace omni::runtime {

// Where `head` is given. Type and next are not set.
inline XrView EyeView(const XrPosef& head, uint32_t eye) {
  constexpr float kHalfEyeDistance_m = 0.032F;
  constexpr float kHalfFieldOfView_rad = 0.785F;
  XrPosef offset = kIdentity;
  offset.position.x = eye == 0 ? -kHalfEyeDistance_m : kHalfEyeDistance_m;
  XrView view{};
  view.pose = Compose(head, offset);
  view.fov = {-kHalfFieldOfView_rad, kHalfFieldOfView_rad, kHalfFieldOfView_rad, -kHalfFieldOfView_rad};
  return view;
}

}  // namespace omni::runtime
