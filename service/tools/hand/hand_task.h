// What somebody who holds the pen is about to do, step by step, from what they perceive. Pure: time is in what is
// perceived, nothing is asked of a clock, a file or a service.
#pragma once

#include <optional>
#include <string>

#include "service/sim/hand/hand_guide.h"
#include "service/tools/hand/perceived.h"

namespace omni::tools {

class HandTask {
 public:
  virtual ~HandTask() = default;
  // Where the pen is wanted next; nothing: leave it where it is. Times of successive calls must not decrease.
  virtual std::optional<sim::HandAim> Next(const Perceived& seen) = 0;
  virtual bool done() const = 0;
  // For people: what was done, and if it is not done, what is missing.
  virtual std::string Account() const = 0;
};

// The longest time that is acted for at once: after a pause the hand goes on, it does not catch up.
inline constexpr double kLongestPause_s = 0.05;

}  // namespace omni::tools
