#pragma once
// XrTime of this runtime = CLOCK_MONOTONIC + a fixed offset, so that code that confuses the two fails at once.

#include <openxr/openxr.h>

#include <ctime>

namespace omni::runtime {

inline constexpr XrTime kTimeOffset_ns = 1'000'000'000'000;
inline constexpr int64_t kSecond_ns = 1'000'000'000;

// Through the vDSO: no system call.
inline XrTime Now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return int64_t{now.tv_sec} * kSecond_ns + now.tv_nsec + kTimeOffset_ns;
}

inline void SleepUntil(XrTime time) {
  const int64_t monotonic_ns = time - kTimeOffset_ns;
  const timespec until{monotonic_ns / kSecond_ns, monotonic_ns % kSecond_ns};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace omni::runtime
