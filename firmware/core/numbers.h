// Basic arithmetic for the control core, without a maths library.
#pragma once

#include <cstdint>
#include <cstring>

#include "firmware/core/board_io.h"

namespace omni::firmware {

constexpr float kStep_s = 250e-6F;
static_assert(kStepPeriod_us == 250, "kStep_s says the same");
constexpr int kStepsPerMs = 1000 / static_cast<int>(kStepPeriod_us);

constexpr bool TestBit(std::uint8_t mask, int i) noexcept { return ((mask >> i) & 1U) != 0; }

constexpr float Abs(float value) noexcept { return value < 0 ? -value : value; }
constexpr float Min(float a, float b) noexcept { return a < b ? a : b; }
constexpr float Max(float a, float b) noexcept { return a > b ? a : b; }

// Returns `low` for NaN.
constexpr float Clamp(float value, float low, float high) noexcept {
  return value > low ? (value < high ? value : high) : low;
}

// Exponent bits all ones: infinity or NaN [IEEE 754].
inline bool IsFinite(float value) noexcept {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return (bits & 0x7F800000U) != 0x7F800000U;
}

}  // namespace omni::firmware
