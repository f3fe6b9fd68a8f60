// Where the hand wants the magnet's centre now: the far end of its spring.
#pragma once

#include "service/sim/fields/vec3.h"

namespace omni::sim {

struct HandTarget {
  Vec3 centre_base_m;
  Vec3 velocity_base_m_s;
  Vec3 axis_base{0, 0, -1};
  bool present = true;
};

}  // namespace omni::sim
