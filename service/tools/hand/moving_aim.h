// An aim that moves at limited speed, as a person moves the pen.
#pragma once

#include <algorithm>

#include "service/base/vec.h"
#include "service/tools/hand/hand_task.h"

namespace omni::tools {

class MovingAim {
 public:
  bool placed() const noexcept { return placed_; }
  void Place(const base::Vec3& tip_base_m) noexcept {
    tip_base_m_ = tip_base_m;
    placed_ = true;
  }
  const base::Vec3& tip_base_m() const noexcept { return tip_base_m_; }
  sim::HandAim aim() const noexcept { return {.tip_base_m = tip_base_m_}; }

  // True: it is there.
  bool MoveTo(const base::Vec3& goal_base_m, double speed_m_s, double dt_s) noexcept {
    const base::Vec3 way = goal_base_m - tip_base_m_;
    const double left_m = base::Norm(way), step_m = speed_m_s * dt_s;
    tip_base_m_ = left_m > step_m ? tip_base_m_ + (step_m / left_m) * way : goal_base_m;
    return left_m <= step_m;
  }

 private:
  bool placed_ = false;
  base::Vec3 tip_base_m_;
};

// Time steps between calls; long pauses are clamped.
class Steps {
 public:
  double Next(double t_s) noexcept {
    const double dt_s = begun_ ? std::clamp(t_s - last_s_, 0.0, kLongestPause_s) : 0;
    begun_ = true;
    last_s_ = t_s;
    return dt_s;
  }

 private:
  bool begun_ = false;
  double last_s_ = 0;
};

}  // namespace omni::tools
