// How many instructions a piece of code takes. SysTick runs at 25 MHz of emulated time; with `-icount shift=N` every
// instruction takes 2^N ns of it, so that the count is exact and the same on every machine. The counter measures the
// rate itself. Without -icount emulated time is the host's, and the figures mean nothing.
#pragma once

#include <cstdint>

namespace omni::firmware::board {

class InstructionCounter {
 public:
  // Starts SysTick [ARMv7-M, B3.3] and measures code of known length.
  InstructionCounter() noexcept;

  void Begin() noexcept;
  // Since Begin. At most 2^24 ticks, at shift=10 650,000 instructions: more comes out smaller.
  std::uint32_t End() const noexcept;

  // Ticks of 1024 instructions; 0: not measured.
  std::uint32_t rate() const noexcept { return ticks_of_1024_; }

 private:
  std::uint32_t Elapsed() const noexcept;

  std::uint32_t begin_ = 0;
  std::uint32_t ticks_of_nothing_ = 0;
  std::uint32_t ticks_of_1024_ = 0;
};

}  // namespace omni::firmware::board
