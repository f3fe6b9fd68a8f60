// A second look at what goes to the bridges, which asks neither Drive nor the core's state of the moment: a duty other
// than zero only while armed, in the self-test, or in the ramp that ends an armed state. docs/theory/firmware.md (29)
#pragma once

#include "firmware/core/board_io.h"

namespace omni::firmware {

class OutputCheck {
 public:
  // A state was entered, in the order of the core.
  void Enter(wire::State state) noexcept { state_ = state; }

  // Every step, after all else. False: a bridge would be driven that may not be.
  bool Allows(const Outputs& outputs) noexcept;

 private:
  wire::State state_ = wire::State::kBoot;
  int left_steps_ = 0;  // of the ramp
};

}  // namespace omni::firmware
