// Runs the control core on a board, in this order so that control never waits for the link: read, step, write, frames.
#pragma once

#include "firmware/core/core.h"

namespace omni::firmware {

// Hardware:
//   void Read(Inputs&)                                            the chips' present values
//   void Write(const Outputs&)
//   std::size_t Receive(std::uint8_t* frame, std::size_t capacity)  0: none waits
//   bool Send(const std::uint8_t* frame, std::size_t size)          false: no room now; the frame is lost
template <class Hardware>
class Runner {
 public:
  Runner(Hardware& hardware, const Settings& settings, ResetCause cause, std::uint32_t nonce_seed, FaultRecord& record)
      : hardware_(hardware), core_(settings, cause, nonce_seed, record) {}

  // Every kStepPeriod_us.
  void Step() {
    Inputs inputs;
    hardware_.Read(inputs);
    core_.Step(inputs, outputs_);
    hardware_.Write(outputs_);
    std::uint8_t frame[wire::kFrameSizeMax];
    for (int i = 0; i < kFramesPerStep; ++i) {
      const std::size_t size = core_.NextFrame(frame, sizeof frame);
      if (size == 0 || !hardware_.Send(frame, size)) break;
    }
    // Further frames wait for the next step: a flood of frames does not delay the control.
    for (int i = 0; i < kFramesPerStep; ++i) {
      const std::size_t size = hardware_.Receive(frame, sizeof frame);
      if (size == 0) break;
      core_.Receive(frame, size);
    }
  }

  const Core& core() const { return core_; }

 private:
  static constexpr int kFramesPerStep = 4;

  Hardware& hardware_;
  Core core_;
  Outputs outputs_;
};

}  // namespace omni::firmware
