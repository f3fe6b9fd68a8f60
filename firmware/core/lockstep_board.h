// Executes one request of a board in lockstep. The emulated board runs this, and so does the host beside it: equal
// requests must give equal answers, byte by byte.
#pragma once

#include <cstdint>
#include <optional>
#include <type_traits>

#include "firmware/core/board_io.h"
#include "firmware/core/core.h"

namespace omni::firmware {

// One control step of a core in another process: the data sent over two FIFOs to an emulated board and back.
// Fixed size, little endian on both sides; a length of 0 means no frame.
constexpr int kLockstepFrames = 2;  // in each direction per step; the rest waits for the next one

struct LockstepFrame {
  std::uint16_t size = 0;
  std::uint8_t bytes[wire::kFrameSizeMax] = {};
  std::uint8_t reserved[7] = {};
};
static_assert(sizeof(LockstepFrame) == 520, "same layout everywhere");

enum class LockstepOp : std::uint32_t { kStep = 1, kReset = 2, kExit = 3 };

struct LockstepRequest {
  LockstepOp op = LockstepOp::kStep;
  std::uint32_t argument = 0;  // kReset: a ResetCause; kExit: the exit status
  Inputs inputs;
  LockstepFrame frames[kLockstepFrames];
};
static_assert(sizeof(LockstepRequest) == 8 + 104 + 2 * 520, "same layout everywhere");

struct LockstepAnswer {
  Outputs outputs;
  LockstepFrame frames[kLockstepFrames];
};
static_assert(sizeof(LockstepAnswer) == 16 + 2 * 520, "same layout everywhere");
static_assert(std::has_unique_object_representations<LockstepRequest>::value &&
                  std::has_unique_object_representations<LockstepAnswer>::value,
              "no hidden padding: every byte sent belongs to a field");

class LockstepBoard {
 public:
  // `record` is in memory that a reset keeps. `start`: counts the resets, so that every start has its own nonces.
  LockstepBoard(const Settings& settings, ResetCause cause, std::uint32_t start, FaultRecord& record) noexcept;

  // kStep: frames in, one control step, frames out. kReset: a new core with the record of the old one; no outputs, no
  // frames. Anything else, an unknown cause of a reset among them, is refused and counted: the core does not run, and
  // the answer's outputs brake and sleep. A frame with an impossible length is passed to the core as an empty one,
  // which refuses and counts it.
  void HandleRequest(const LockstepRequest& request, LockstepAnswer& answer) noexcept;

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
