// CLOCK_MONOTONIC in nanoseconds: the one time base of the service.
#pragma once

#include <cstdint>
#include <ctime>

namespace omni::base {

inline std::int64_t MonotonicNow_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);  // vDSO: no system call
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace omni::base
