// Executes one request of a board in lockstep. The emulated board runs this, and so does the host beside it: equal
// requests must give equal answers, byte by byte.
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/core/core.h"
#include "firmware/core/lockstep.h"

namespace omni::firmware {

class LockstepBoard {
 public:
  // `record` is in memory that a reset keeps. `start`: counts the resets, so that every start has its own nonces.
  LockstepBoard(const Settings& settings, ResetCause cause, std::uint32_t start, FaultRecord& record) noexcept;

  // kStep: frames in, one control step, frames out. kReset: a new core with the record of the old one; no outputs, no
  // frames. Anything else, an unknown cause of a reset among them, is refused and counted: the core does not run, and
  // the answer's outputs brake and sleep. A frame with an impossible length is passed to the core as an empty one,
  // which refuses and counts it.
  void Answer(const LockstepRequest& request, LockstepAnswer& answer) noexcept;

  const Core& core() const noexcept { return *core_; }
  std::uint32_t refused() const noexcept { return refused_; }

 private:
  void Start(ResetCause cause) noexcept;
  void Step(const LockstepRequest& request, LockstepAnswer& answer) noexcept;

  const Settings settings_;
  FaultRecord& record_;
  std::optional<Core> core_;
  std::uint32_t start_;
  std::uint32_t refused_ = 0;
};

// False: no ResetCause has this number.
bool IsResetCause(std::uint32_t number) noexcept;

}  // namespace omni::firmware
