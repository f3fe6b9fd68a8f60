// Time and the control step's interrupt. GPT2 counts microseconds of the crystal (+-50 ppm) and captures the fan's
// edges; PIT channel 0 interrupts every control step. Both run from the same 24 MHz, so they never drift apart.
#pragma once

#include <cstdint>

namespace omni::board {

class Timebase {
 public:
  // GPT2 counts from 0, PIT interrupts every `step_us` once interrupts are on.
  void Start(std::uint32_t step_us) noexcept;

  // Microseconds since Start. The counter wraps after 71 minutes; Now must be called more often than that, by one
  // interrupt level only (the control step does).
  std::uint64_t Now() noexcept;

  // The low 32 bits, from any context.
  static std::uint32_t NowLow32_us() noexcept;

  // Call first in the control interrupt. False: the interrupt was not this timer's.
  static bool AcknowledgeStep() noexcept;

  // firmware/drivers/fan_tach.h: falling edges. Only the newest is kept by the hardware; at 4 kHz none is missed below
  // 120000 pulses a minute.
  struct FanCapture {
    bool NextEdge(std::uint32_t& t_us) noexcept;
    std::uint32_t Now_us() noexcept { return NowLow32_us(); }
  };

 private:
  std::uint32_t last_ = 0;
  std::uint64_t high_ = 0;
};

}  // namespace omni::board
