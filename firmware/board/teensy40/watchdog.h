// WDOG3: resets the chip when the control step has not fed it for 8 ms. Started once, it cannot be stopped or changed
// [RM RTWDOG].
#pragma once

#include <cstdint>

namespace omni::board {

constexpr std::uint32_t kWatchdogTimeout_us = 8000;

// The ROM may leave it in any state; until the control step runs nothing may reset the chip.
void StopWatchdogOfRom() noexcept;
void StartWatchdog() noexcept;
void FeedWatchdog() noexcept;

}  // namespace omni::board
