// The far end of the hand's spring under a HandGuide: it goes to the newest aim as an arm does, smoothly, and stays
// there until the next one. The rate and jitter of the aims do not change what it can do.
#pragma once

#include "service/sim/hand/hand_guide.h"
#include "service/sim/hand/hand_target.h"

namespace omni::sim {

class LedPath {
 public:
  // At rest at `start`.
  LedPath(const HandTarget& start, double tip_offset_m) noexcept;

  // A pen that was away comes down to its aim from kEnterFrom_m above, where the base does not feel it; gently, so that
  // it does not swing past an aim that is just above a surface.
  static constexpr double kEnterFrom_m = 0.15;
  void Aim(const HandAim& aim) noexcept;
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
