// CLOCK_MONOTONIC in nanoseconds: the one time base of the service, and arithmetic on its stamps.
#pragma once

#include <cstdint>
#include <ctime>
#include <limits>

namespace omni::base {

inline std::int64_t MonotonicNow_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);  // vDSO: no system call
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

// Arithmetic on arbitrary time stamps in ns: a device's clock is untrusted input. Saturates instead of overflowing.
inline std::int64_t StampDifference_ns(std::int64_t later_ns, std::int64_t earlier_ns) noexcept {
  std::int64_t difference_ns = 0;
  if (!__builtin_sub_overflow(later_ns, earlier_ns, &difference_ns)) return difference_ns;
  using Limits = std::numeric_limits<std::int64_t>;
  return later_ns < earlier_ns ? Limits::min() : Limits::max();
}

inline std::int64_t StampAfter_ns(std::int64_t stamp_ns, std::int64_t step_ns) noexcept {
  std::int64_t sum_ns = 0;
  if (!__builtin_add_overflow(stamp_ns, step_ns, &sum_ns)) return sum_ns;
  using Limits = std::numeric_limits<std::int64_t>;
  return step_ns < 0 ? Limits::min() : Limits::max();
}

inline double Elapsed_s(std::int64_t later_ns, std::int64_t earlier_ns) noexcept {
  return 1e-9 * static_cast<double>(StampDifference_ns(later_ns, earlier_ns));
}

}  // namespace omni::base
