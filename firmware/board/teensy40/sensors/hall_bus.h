// Eight magnetometers on LPSPI4: mode 3, 8.25 MHz, chip selects by a 74HC138.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/drivers/chip_status.h"

namespace omni::board {

constexpr std::uint32_t kSpiDivider = 8;
static_assert(kSpiSource_Hz / kSpiDivider <= 10'000'000, "LIS3MDL, SPI clock at most 10 MHz");

void StartHallBus() noexcept;

// firmware/drivers/lis3mdl.h. A transfer is one section without interrupts, at most 16 us: the control interrupt reads
// the sensors while the main loop may be configuring one.
class HallBus {
 public:
  explicit HallBus(std::uint8_t index) noexcept : index_(index) {}
  drivers::BusStatus Transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t size) noexcept;

 private:
  std::uint8_t index_;  // 0 to 7
};

}  // namespace omni::board
