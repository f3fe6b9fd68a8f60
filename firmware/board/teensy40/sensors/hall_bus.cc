#include "firmware/board/teensy40/sensors/hall_array.h"

#include "firmware/board/teensy40/chip/cpu.h"
#include "firmware/board/teensy40/chip/pins.h"
#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {

// RM LPSPI.
constexpr std::uint32_t kEnable = 1U, kReset = 2U, kEmptyFifos = 3U << 8;  // CR
constexpr std::uint32_t kMaster = 1U;                                      // CFGR1
constexpr std::uint32_t kMode3EightBits = (3U << 30) | 7U;                 // TCR: CPOL, CPHA, frames of 8
constexpr std::uint32_t kReceiveEmpty = 1U << 1;                           // RSR
constexpr std::size_t kFifoWords = 16;
constexpr std::uint32_t kDelayTicks = 1;

// A byte takes 4 us; the bound for all keeps the bound on the interrupt's length.
constexpr std::uint32_t kPolls = 4000;

// 74HC138: 20 ns at 3.3 V from address or enable to output [Nexperia 74HC138, dynamic characteristics: 60 ns at 2 V];
// LIS3MDL wants 5 ns before the clock and 8 ns after it.
void Settle() noexcept {
  for (int i = 0; i < 24; ++i) asm volatile("nop");
}

void Select(std::uint8_t index) noexcept {
  SetPin(Signal::kHallAddress0, (index & 1) != 0);
  SetPin(Signal::kHallAddress1, (index & 2) != 0);
  SetPin(Signal::kHallAddress2, (index & 4) != 0);
  Settle();
  SetPin(Signal::kHallSelectOff, false);
  Settle();
}

void Deselect() noexcept {
  Settle();
  SetPin(Signal::kHallSelectOff, true);
  Settle();
}

bool Exchange(const std::uint8_t* out, std::uint8_t* in, std::size_t size) noexcept {
  Lpspi& spi = lpspi4();
  for (std::size_t i = 0; i < size; ++i) spi.TDR = out[i];
  for (std::size_t i = 0; i < size; ++i) {
    std::uint32_t polls = 0;
    while ((spi.RSR & kReceiveEmpty) != 0) {
      if (++polls > kPolls) return false;
    }
    in[i] = static_cast<std::uint8_t>(spi.RDR);
  }
  return true;
}

}  // namespace

void StartHallBus() noexcept {
  Lpspi& spi = lpspi4();
  spi.CR = kReset;
  spi.CR = 0;
  spi.IER = 0;
  spi.DER = 0;
  spi.CFGR0 = 0;
  spi.CFGR1 = kMaster;
  spi.CCR = (kDelayTicks << 24) | (kDelayTicks << 16) | (kDelayTicks << 8) | (kSpiDivider - 2);
  spi.FCR = 0;
  spi.CR = kEnable;
  spi.TCR = kMode3EightBits;
}

drivers::BusStatus HallBus::Transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t size) noexcept {
  if (size > kFifoWords) return drivers::BusStatus::kTimeout;
  const Critical critical;
  Select(index_);
  const bool finished = Exchange(out, in, size);
  Deselect();
  if (finished) return drivers::BusStatus::kOk;
  lpspi4().CR = kEnable | kEmptyFifos;
  return drivers::BusStatus::kTimeout;
}

}  // namespace omni::board
