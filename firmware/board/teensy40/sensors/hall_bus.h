// Eight magnetometers on LPSPI4: mode 3, 1.94 MHz, chip selects by a 74HC138. The chip takes 10 MHz, but carrier boards
// with level shifters (a FET and a pull-up on SCL and SDA, as Pololu's) have edges of 100 ns.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/drivers/chip_status.h"

namespace omni::board {

#ifndef OMNI_HALL_SPI_DIVIDER  // the bring-up compares clocks: firmware/README.md
#define OMNI_HALL_SPI_DIVIDER 34
#endif
constexpr std::uint32_t kSpiDivider = OMNI_HALL_SPI_DIVIDER;
static_assert(kSpiSource_Hz / kSpiDivider <= 2'000'000, "slow enough for level shifters; the LIS3MDL takes 10 MHz");

void StartHallBus() noexcept;

// firmware/drivers/lis3mdl.h. A transfer is one section without interrupts, at most 40 us: the control interrupt reads
// the sensors while the main loop may be configuring one.
class HallBus {
 public:
  explicit HallBus(std::uint8_t index) noexcept : index_(index) {}
  drivers::BusStatus Transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t size) noexcept;

 private:
  std::uint8_t index_;  // 0 to 7
};

}  // namespace omni::board
