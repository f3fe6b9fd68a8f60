// A verdict about what may come and go: so many seconds of one kind in a row change it.
#pragma once

#include <optional>

namespace omni::daemon {

class Verdict {
 public:
  explicit Verdict(int seconds) : seconds_(seconds) {}

  // Of one second; nothing: it says nothing, and the verdict stays.
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

// Of the samples of a second.
inline bool IsMostly(int some, int all) noexcept { return some > 0 && some >= 0.8 * all; }

}  // namespace omni::daemon
