// A section without interrupts; nests. For a bus that the control interrupt and the main loop share.
#pragma once

#include <cstdint>

#include "firmware/board/teensy40/chip/register_access.h"

namespace omni::board {

class Critical {
 public:
  Critical() noexcept : before_(InterruptMask()) { InterruptsOff(); }
  ~Critical() { SetInterruptMask(before_); }
  Critical(const Critical&) = delete;
  Critical& operator=(const Critical&) = delete;

 private:
  std::uint32_t before_;
};

}  // namespace omni::board
