// Decides step by step how a person would move the pen, from what they perceive. Time is part of the perception: it
// uses no clock, file or service.
#pragma once

#include <optional>
#include <string>

#include "service/sim/hand/hand_guide.h"
#include "service/tools/hand/perceived.h"

namespace omni::tools {

class HandTask {
 public:
  virtual ~HandTask() = default;
  // Next aim of the hand; nothing: keep the last one. Times of successive calls must not decrease.
  virtual std::optional<sim::HandAim> Next(const Perceived& seen) = 0;
  virtual bool done() const = 0;
  // What was done, and if the task is not done, what is missing.
  virtual std::string Account() const = 0;
};

// Longest time step: after a pause the hand continues without catching up.
inline constexpr double kLongestPause_s = 0.05;

}  // namespace omni::tools
