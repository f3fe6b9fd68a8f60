// A verdict with hysteresis: it changes after `seconds` contrary seconds in a row.
#pragma once

#include <optional>

namespace omni::room {

class Verdict {
 public:
  explicit Verdict(int seconds) : seconds_(seconds) {}

  // Result of one second; empty: undecided, the verdict stays.
  void Add(std::optional<bool> so) noexcept {
    if (!so) return;
    against_ = *so != holds_ ? against_ + 1 : 0;
    if (against_ < seconds_) return;
    holds_ = !holds_;
    against_ = 0;
  }
  bool holds() const noexcept { return holds_; }

 private:
  int seconds_;
  int against_ = 0;  // seconds that speak against it, in a row
  bool holds_ = false;
};

// At least 80 % of a second's samples.
inline bool IsMostly(int some, int all) noexcept { return some > 0 && some >= 0.8 * all; }

}  // namespace omni::room
