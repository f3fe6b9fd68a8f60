// Detects a sensor that repeats the same reading. docs/theory/tracking.md, Doubt
#pragma once

#include <array>
#include <type_traits>

#include "service/base/hall_scan.h"

namespace omni::tracker {

struct Repetition {
  std::array<base::Vec3, base::kSensorCount> last_T{};
  std::array<int, base::kSensorCount> times{};  // in a row that a fresh sample was the one before
};
static_assert(std::is_trivially_copyable_v<Repetition>);

// The sensor that has repeated itself `times_min` times while all others that are fresh have just changed; -1: none.
// Noise never repeats three axes for long.
int FindFrozen(const base::HallScan& scan, int times_min, Repetition& repetition) noexcept;

// After FindFrozen: all fresh sensors have repeated themselves so often. The base sends old measurements.
bool IsAllFrozen(const base::HallScan& scan, int times_min, const Repetition& repetition) noexcept;

}  // namespace omni::tracker
