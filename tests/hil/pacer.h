// Keeps device time beside the wall clock: a device instant is never early, and how late it is is counted.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstdint>

#include "service/base/clock.h"
#include "service/base/limits.h"

namespace omni::hil {

struct PaceCounts {
  std::uint64_t waits = 0;
  std::uint64_t late = 0;   // more than a tick
  std::uint64_t slips = 0;  // later than kCatchUpMax_ns: device time was set anew
  std::int64_t worst_late_ns = 0;
};

class Pacer {
 public:
  // Device time 0 is now.
  Pacer() : zero_ns_(base::MonotonicNow_ns()) {}

  // Until the wall clock shows device time `t_ns`.
  void WaitFor(std::int64_t t_ns) {
    ++counts_.waits;
    const std::int64_t due_ns = zero_ns_ + t_ns;
    const std::int64_t late_ns = base::MonotonicNow_ns() - due_ns;
    if (late_ns < 0) {
      const timespec wake{due_ns / 1'000'000'000, due_ns % 1'000'000'000};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
      return;
    }
    counts_.worst_late_ns = std::max(counts_.worst_late_ns, late_ns);
    if (late_ns > base::kTickPeriod_ns) ++counts_.late;
    if (late_ns > kCatchUpMax_ns) {
      zero_ns_ += late_ns;
      ++counts_.slips;
    }
  }

  // CLOCK_MONOTONIC at device time 0.
  std::int64_t zero_ns() const { return zero_ns_; }
  const PaceCounts& counts() const { return counts_; }

 private:
  static constexpr std::int64_t kCatchUpMax_ns = 100 * base::kTickPeriod_ns;
  std::int64_t zero_ns_;
  PaceCounts counts_;
};

}  // namespace omni::hil
