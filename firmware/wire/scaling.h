// The wire's units, and rounding to them without a maths library.
#pragma once

#include <cstdint>
#include <limits>

namespace omni::wire {

constexpr double kCurrentUnit_A = 1.25e-3;  // INA260
constexpr double kSupplyUnit_V = 1.25e-3;   // INA260
constexpr double kTemperatureUnit_K = 0.01;
constexpr std::int64_t kAgeUnit_ns = 20'000;

// Nearest count of value / unit, clipped to what Count can hold; NaN gives 0.
template <class Count>
constexpr Count ToCounts(double value, double unit) noexcept {
  const double counts = value / unit;
  constexpr double kMin = static_cast<double>(std::numeric_limits<Count>::min());
  constexpr double kMax = static_cast<double>(std::numeric_limits<Count>::max());
  if (counts >= kMax) return std::numeric_limits<Count>::max();
  if (counts <= kMin) return std::numeric_limits<Count>::min();
  if (!(counts > kMin && counts < kMax)) return 0;
  return static_cast<Count>(counts >= 0 ? counts + 0.5 : counts - 0.5);
}

}  // namespace omni::wire
