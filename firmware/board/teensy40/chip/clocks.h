// 600 MHz core, 150 MHz peripheral bus, 24 MHz crystal for timers, 60 MHz for I2C, 66 MHz for SPI [RM CCM].
#pragma once

#include <cstdint>

namespace omni::board {

constexpr std::uint32_t kCore_MHz = 600;
constexpr std::uint32_t kBus_Hz = 150'000'000;   // FlexPWM
constexpr std::uint32_t kTimer_Hz = 24'000'000;  // GPT, PIT: the crystal, whatever the core does
constexpr std::uint32_t kSpiSource_Hz = 66'000'000;
constexpr std::uint32_t kI2cSource_Hz = 60'000'000;

// Everything that is used, including pins and watchdog. Called first.
void OpenClockGates() noexcept;

// From what the boot ROM left (396 MHz) to the above. The core's voltage rises first. Waits for every lock; a PLL that
// never locks ends in the watchdog's reset with all bridges asleep.
void SetUpClocks() noexcept;

// The last part of the above: the sources of SPI, I2C and timers. For start-up code other than this board's.
void SetUpPeripheralClocks() noexcept;

}  // namespace omni::board
