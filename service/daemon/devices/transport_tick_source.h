// Clocks the loop by the arrival of a transport's telemetry.
#pragma once

#include "service/device/transport.h"
#include "service/loop/tick_source.h"

namespace omni::daemon {

class TransportTickSource : public loop::TickSource {
 public:
  // `transport` outlives this. patience_ns: how long Wait blocks before it returns kTimeout.
  explicit TransportTickSource(device::Transport& transport, std::int64_t patience_ns = 20'000'000)
      : transport_(transport), patience_ns_(patience_ns) {}

  loop::WaitStatus Wait(base::HallScan& scan) noexcept override {
    switch (transport_.Read(scan, patience_ns_)) {
      case device::ReadStatus::kScan:
        return loop::WaitStatus::kTick;
      case device::ReadStatus::kTimeout:
        return loop::WaitStatus::kTimeout;
      case device::ReadStatus::kEnd:
        return loop::WaitStatus::kEnd;
      case device::ReadStatus::kGone:
        break;
    }
    return loop::WaitStatus::kGone;
  }

  void Apply(const base::CoilCurrents& currents) noexcept override { transport_.Write(currents); }

 private:
  device::Transport& transport_;
  std::int64_t patience_ns_;
};

}  // namespace omni::daemon
