// Data kept across a reset: the core's fault record and how the last run ended. Start-up code does not touch it; after
// power-on it is random, which its check detects.
#pragma once

#include <cstdint>

#include "firmware/core/core.h"

namespace omni::board {

constexpr std::uint32_t kCrashed = 0xC0DEFA17;

struct Retained {
  firmware::FaultRecord record;
  std::uint32_t resets;   // counts up from a random value, so that the core's nonces differ after every reset
  std::uint32_t crashed;  // kCrashed: the last run ended in a processor fault
};

Retained& retained() noexcept;

// Why the chip started; call once, because reading clears it. `crashed`: the last run ended in a processor fault, which
// counts as a watchdog reset.
firmware::ResetCause PopResetCause(bool crashed) noexcept;

// The same for the data kept here, which it counts and clears.
firmware::ResetCause PopResetCause() noexcept;

}  // namespace omni::board
