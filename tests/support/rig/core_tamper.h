// Corrupts the state of a control core, as a stray write or a flipped bit would.
#pragma once

#include "firmware/core/core.h"

namespace omni::firmware {

struct CoreTamper {
  static Drive& DriveOf(Core& core) { return core.drive_; }
  static void SetState(Core& core, wire::State state) { core.state_ = state; }
  static void SetPoints(Core& core, float current_A) {
    for (float& set_point_A : core.set_point_A_) set_point_A = current_A;
  }
};

}  // namespace omni::firmware
