// The chip itself: its identity, temperature and watchdog.
#pragma once

#include <cstdint>

#include "firmware/core/link/settings.h"

namespace omni::board {

// The core's defaults with this chip's own number as serial: "omni-" and ten hexadecimal digits of the fuses.
firmware::Settings ChipSettings() noexcept;

// The chip's own temperature, for telemetry: it warns of a hot enclosure, not of a hot coil [RM TEMPMON].
class Thermometer {
 public:
  void Start() noexcept;
  // 0.01 C; the last finished measurement.
  std::int16_t Read() noexcept;

 private:
  std::int32_t room_count_ = 0, hot_count_ = 0, hot_C_ = 0;
  std::int16_t last_ = 0;
};

// WDOG3: resets the chip when the control step has not fed it for 8 ms. Started once, it cannot be stopped or changed
// [RM RTWDOG].
constexpr std::uint32_t kWatchdogTimeout_us = 8000;

// The ROM may leave it in any state; until the control step runs nothing may reset the chip.
void StopWatchdogOfRom() noexcept;
void StartWatchdog() noexcept;
void FeedWatchdog() noexcept;

}  // namespace omni::board
