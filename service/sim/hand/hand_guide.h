// Guides the simulated hand while the twin runs: a program in a person's place, later a mouse. It decides where the pen
// is wanted, and nothing else: mass, damping, stiffness and tremor stay the hand's own.
#pragma once

#include "service/base/vec.h"
#include "service/sim/fields/vec3.h"

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

// Where the hand wants the magnet's centre now: the far end of its spring.
struct HandTarget {
  Vec3 centre_base_m;
  Vec3 velocity_base_m_s;
  Vec3 axis_base{0, 0, -1};
  bool present = true;
};

// The far end of the hand's spring under a HandGuide (led_path.cc): it goes to the newest aim as an arm does, smoothly,
// and stays there until the next one. The rate and jitter of the aims do not change what it can do.
class LedPath {
 public:
  // At rest at `start`.
  LedPath(const HandTarget& start, double tip_offset_m) noexcept;

  // A pen that was away comes down to its aim from kEnterFrom_m above, where the base does not feel it; gently, so that
  // it does not swing past an aim that is just above a surface.
  static constexpr double kEnterFrom_m = 0.15;
  void SetAim(const HandAim& aim) noexcept;
  void Step(double dt_s) noexcept;

  HandTarget Target() const noexcept;

 private:
  void StepTip(double dt_s) noexcept;
  void StepAxis(double dt_s) noexcept;

  HandAim aim_;
  bool enters_ = false;  // comes down
  double tip_offset_m_;
  Vec3 tip_m_, velocity_m_s_;
  Vec3 axis_, axis_rate_1_s_;
};

}  // namespace omni::sim
