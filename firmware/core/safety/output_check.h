// A second check of the outputs to the bridges, independent of Drive and of the core's current state: a non-zero duty
// only while armed, in the self-test, or in the ramp that ends an armed state. docs/theory/firmware.md (6.5)
#pragma once

#include "firmware/core/board_io.h"

namespace omni::firmware {

class OutputCheck {
 public:
  // Notes each state that the core enters, in order.
  void Enter(wire::State state) noexcept { state_ = state; }

  // Every step, last. False: a bridge would be driven that must not be.
  bool Allows(const Outputs& outputs) noexcept;

 private:
  wire::State state_ = wire::State::kBoot;
  int left_steps_ = 0;  // of the ramp
};

}  // namespace omni::firmware
