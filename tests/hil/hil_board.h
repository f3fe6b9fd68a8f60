// One interface to the control core, in this process or in an emulated Cortex-M7.
#pragma once

#include <memory>
#include <string>

#include "firmware/core/lockstep_board.h"
#include "service/base/result.h"

namespace omni::hil {

class HilBoard {
 public:
  virtual ~HilBoard() = default;
  // One control step. After an error the board is unusable.
  virtual base::Status Step(const firmware::LockstepRequest& request, firmware::LockstepAnswer& answer) = 0;
  // Restarts with the previous fault record.
  virtual base::Status Reset(firmware::ResetCause cause) = 0;
};

// `kind`: "host" or "qemu". An error says what is missing.
base::Result<std::unique_ptr<HilBoard>> MakeBoard(const std::string& kind);

}  // namespace omni::hil
