// One control step of a core in another process: the data sent over two FIFOs to an emulated board and back.
// Fixed size, little endian on both sides; a length of 0 means no frame.
#pragma once

#include <cstdint>
#include <type_traits>

#include "firmware/core/board_io.h"

namespace omni::firmware {

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

}  // namespace omni::firmware
