// What outlives a reset: the core's fault record and how the last run ended. Start-up code does not touch it; after
// power on it is noise, and says so by its check.
#pragma once

#include <cstdint>

#include "firmware/core/core.h"

namespace omni::board {

constexpr std::uint32_t kCrashed = 0xC0DEFA17;

struct Retained {
  firmware::FaultRecord record;
  std::uint32_t resets;   // counts up, from noise: the core's nonces differ after every reset
  std::uint32_t crashed;  // kCrashed: the last run ended in a processor fault
};

Retained& retained() noexcept;

// Why the chip started, asked once: the answer is cleared. `crashed`: the last run ended in a processor fault, which
// counts as the watchdog's.
firmware::ResetCause PopResetCause(bool crashed) noexcept;

// The same with what is kept here, which it counts and clears.
firmware::ResetCause PopResetCause() noexcept;

}  // namespace omni::board
