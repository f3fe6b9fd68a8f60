// The control core: one piece of code that runs in the micro-controller, in an emulated one, in unit tests and inside
// the twin. No hardware, no heap, no clock of its own, no libm: inputs of a control step in, outputs out, frames in and
// out. Equal inputs give equal bits on every target (only + - * / and sqrt of float, nothing fused).
//
//   boot -> self-test -> idle <-> armed, any -> fault
//
// Coils are driven in kArmed only. Whatever is wrong: currents ramp to zero within 5 ms, the bridges brake, and after
// 10 ms they sleep (brake before sleep, so that the bus does not pump up). docs/theory/firmware.md
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/core/board_io.h"
#include "firmware/core/settings.h"

namespace omni::firmware {

// Kept across a reset in memory that start-up does not clear; `check` tells a record from noise.
struct FaultRecord {
  std::uint32_t fault = 0, faults = 0;
  std::uint8_t state = 0, part = 0;
  std::uint16_t count = 0;  // of faults since the record was cleared
  float value = 0;
  std::uint64_t t_us = 0;
  std::uint32_t check = 0;
};

class Core {
 public:
  // `record` is that of before the reset, or noise. `nonce_seed` need not be random, only another one at every reset.
  Core(const Settings& settings, ResetCause cause, std::uint32_t nonce_seed, FaultRecord& record) noexcept;

  // One whole frame that came since the step before. What is not valid is counted and does nothing.
  void Receive(const std::uint8_t* frame, std::size_t size) noexcept;

  // Every kStepPeriod_us.
  void Step(const Inputs& inputs, Outputs& outputs) noexcept;

  // Frames to send after a Step, until 0: answers, and telemetry after every kStepsPerTick-th. A frame that does not
  // fit `capacity` is lost.
  std::size_t NextFrame(std::uint8_t* frame, std::size_t capacity) noexcept;

  wire::State state() const noexcept;
  std::uint32_t faults() const noexcept;
};

}  // namespace omni::firmware
