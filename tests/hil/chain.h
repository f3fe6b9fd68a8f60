// Plant <-> control core <-> USB function: a whole base without the plug. The caller steps it; frames are exchanged on
// the emulator's threads.
#pragma once

#include <cstdint>
#include <deque>
#include <mutex>

#include "firmware/wire/messages.h"
#include "service/base/result.h"
#include "service/sim/coils/plant.h"
#include "tests/hil/faulty_link.h"
#include "tests/hil/hil_board.h"
#include "tests/hil/usb/usb_function.h"

namespace omni::hil {

struct ChainCounts {
  std::uint64_t steps = 0;
  std::uint64_t telemetry = 0;
  std::uint64_t commands = 0;      // valid ones that reached the core
  std::uint64_t lost_to_host = 0;  // not fetched in time
  std::uint64_t lost_to_core = 0;  // arrived faster than the core reads them
};

class Chain final : public UsbFunction {
 public:
  // Both outlive the chain.
  Chain(sim::Plant& plant, HilBoard& board);

  // One control step: frames of the host, the plant's inputs, the core's outputs, the plant.
  base::Status Step();

  // Restarts the controller; waiting frames are lost.
  base::Status Reset(firmware::ResetCause cause);

  // Of the last telemetry that left the core, and of the last command that reached it. The stepping thread's.
  const wire::Telemetry& telemetry() const { return telemetry_; }
  sim::HostView host_view() const;
  const ChainCounts& counts() const { return counts_; }

  void HostFrame(const std::uint8_t* data, std::size_t size) override;
  std::size_t NextFrame(std::uint8_t* frame, std::size_t capacity) override;
  int VendorRequest(std::uint8_t request, std::uint16_t value, std::uint16_t index, std::uint8_t* answer,
                    std::size_t capacity) override;
  void Unplugged() override;

 private:
  void Push(const Frame& frame);
  void HandleHostFrames();
  void GiveHostFrames(const firmware::LockstepAnswer& answer);
  void CheckCommand(const firmware::LockstepFrame& frame);
  void CheckAnswer(const firmware::LockstepFrame& frame);

  static constexpr std::size_t kFromHostMax = 64;  // full: the newest is lost
  static constexpr std::size_t kToHostMax = 8;     // full: the oldest is lost, because the host needs the newest

  sim::Plant& plant_;
  HilBoard& board_;
  firmware::LockstepRequest request_;
  firmware::Outputs outputs_;
  wire::Telemetry telemetry_;
  sim::CoilArray set_point_A_{};
  std::int64_t command_ns_ = 0;
  ChainCounts counts_;

  std::mutex mutex_;
  std::deque<Frame> from_host_, to_host_;
  Frame hello_;  // the newest that left the core
};

}  // namespace omni::hil
