// Keeps virtual time from running ahead of the wall clock, for users and programs that are not under it. Lost time is
// not made up.
#pragma once

#include <time.h>

#include <cstdint>

#include "service/base/clock.h"

namespace omni::hil {

class Pacer {
 public:
  // Waits until `period_ns` of the wall clock since the last call. Late: more had already passed.
  void Wait(std::int64_t period_ns) {
    due_ns_ += period_ns;
    const std::int64_t now_ns = base::MonotonicNow_ns();
    if (now_ns >= due_ns_) {
      ++late_;
      behind_ns_ += now_ns - due_ns_;
      due_ns_ = now_ns;
      return;
    }
    const timespec wake{due_ns_ / 1'000'000'000, due_ns_ % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
  }

  std::uint64_t late() const { return late_; }           // calls
  std::int64_t behind_ns() const { return behind_ns_; }  // in all

 private:
  std::int64_t due_ns_ = base::MonotonicNow_ns();
  std::uint64_t late_ = 0;
  std::int64_t behind_ns_ = 0;
};

}  // namespace omni::hil
