// What a person perceives at the pen, and how they move it for a task.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "service/base/vec.h"
#include "service/sim/hand/hand_guide.h"

namespace omni::tools {

// What a person at the pen perceives through an application. Everything comes from what omnid publishes to clients,
// nothing from the simulation.
struct PerceivedCar {
  bool on = false;  // there is one
  base::Vec3 position_base_m;
  double heading_rad = 0;
  double speed_m_s = 0;
  std::uint32_t laps = 0, hits = 0;
};

struct Perceived {
  double t_s = 0;  // the person's clock
  bool pen = false;
  base::Vec3 tip_base_m;
  double press_N = 0;                // of the tip on what it touches
  std::uint32_t select_presses = 0;  // so far
  PerceivedCar car;
  bool soft = false;  // a soft body is drawn ...
  double dent_m = 0;  // ... with this largest displacement
  bool clay = false;  // something can be sculpted ...
  std::uint32_t strokes = 0;
  bool stroke_open = false;
};

// Decides step by step how a person would move the pen, from what they perceive. Time is part of the perception: it
// uses no clock, file or service.
class HandTask {
 public:
  virtual ~HandTask() = default;
  // Next aim of the hand; nothing: keep the last one. Times of successive calls must not decrease.
  virtual std::optional<sim::HandAim> NextAim(const Perceived& seen) = 0;
  virtual bool done() const = 0;
  // What was done, and if the task is not done, what is missing.
  virtual std::string Summary() const = 0;
};

// Longest time step: after a pause the hand continues without catching up.
inline constexpr double kLongestPause_s = 0.05;

// An aim that moves at limited speed, as a person moves the pen.
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
