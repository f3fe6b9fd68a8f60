// The sign of life of a process: a page of shared memory that it writes, and that another process reads without
// trusting it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#include "service/base/clock.h"

namespace omni::base {

struct LifePage {
  std::atomic<std::uint64_t> beat{0};      // each sign of life adds one
  std::atomic<std::uint64_t> stamp_ns{0};  // CLOCK_MONOTONIC of the newest one; 0: this process writes none

  // Any thread of the process whose page this is.
  void SignalAlive(std::int64_t now_ns) noexcept {
    stamp_ns.store(static_cast<std::uint64_t>(now_ns), std::memory_order_relaxed);
    beat.fetch_add(1, std::memory_order_release);
  }
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free && sizeof(LifePage) == 16);

// The latest time after which there certainly was a sign of life. A beat that is found is younger than the look before,
// and may be no younger: whoever looks late must not take it for a new one. The page's own stamp can only make it
// older.
class LifeWatch {
 public:
  // `now_ns`: CLOCK_MONOTONIC. No system call.
  void Update(const LifePage& page, std::int64_t now_ns) noexcept {
    const std::uint64_t beat = page.beat.load(std::memory_order_acquire);
    if (looked_ && beat != beat_) {
      const auto stamp_ns = static_cast<std::int64_t>(page.stamp_ns.load(std::memory_order_relaxed));
      last_ns_ = stamp_ns == 0 ? looked_ns_ : std::min(looked_ns_, stamp_ns);
    }
    beat_ = beat;
    looked_ns_ = now_ns;
    looked_ = true;
  }
  // Since the last sign of life; without one it is longer than any limit.
  std::int64_t Silence_ns(std::int64_t now_ns) const noexcept { return StampDifference_ns(now_ns, last_ns_); }

 private:
  std::uint64_t beat_ = 0;
  std::int64_t looked_ns_ = 0;
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
  bool looked_ = false;
};

}  // namespace omni::base
