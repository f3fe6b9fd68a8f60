// The control core behind one interface, wherever it runs: in this process or in an emulated Cortex-M7.
#pragma once

#include <memory>
#include <string>

#include "firmware/core/lockstep.h"
#include "service/base/result.h"

namespace omni::hil {

class HilBoard {
 public:
  virtual ~HilBoard() = default;
  // One control step. An error: the board is lost for good.
  virtual base::Status Step(const firmware::LockstepRequest& request, firmware::LockstepAnswer& answer) = 0;
  // A new start with the fault record of before.
  virtual base::Status Reset(firmware::ResetCause cause) = 0;
};

// `kind`: "host" or "qemu". An error says what is missing.
base::Result<std::unique_ptr<HilBoard>> MakeBoard(const std::string& kind);

}  // namespace omni::hil
