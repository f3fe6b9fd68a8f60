// Guides the simulated hand while the twin runs: a program in a person's place, later a mouse. It decides where the pen
// is wanted, and nothing else: mass, damping, stiffness and tremor stay the hand's own.
#pragma once

#include "service/base/vec.h"

namespace omni::sim {

// Where the pen is wanted. Precondition: finite; `axis_base` is a unit vector.
struct HandAim {
  base::Vec3 tip_base_m;           // device point
  base::Vec3 axis_base{0, 0, -1};  // out of the tip
  bool present = true;             // false: the pen is taken away
};

class HandGuide {
 public:
  virtual ~HandGuide() = default;
  // Called once per tick, must not block. False: nothing new, the hand keeps its last aim.
  virtual bool Poll(HandAim& aim) noexcept = 0;
};

}  // namespace omni::sim
