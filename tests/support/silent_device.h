// A base without a pen: an empty scan every millisecond.
#pragma once

#include <chrono>
#include <thread>

#include "service/base/clock.h"
#include "service/device/transport.h"

namespace omni::support {

class SilentDevice : public device::Transport {
 public:
  device::ReadStatus Read(base::HallScan& scan, std::int64_t /*timeout_ns*/) noexcept override {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    scan = {};
    scan.sequence = ++sequence_;
    scan.t_ns = base::MonotonicNow_ns();
    return device::ReadStatus::kScan;
  }
  bool Write(const base::CoilCurrents& /*currents*/) noexcept override { return true; }
  const device::TransportInfo& info() const noexcept override { return info_; }
  device::TransportCounters counters() const noexcept override { return {}; }

 private:
  device::TransportInfo info_{.name = "quiet"};
  std::uint64_t sequence_ = 0;
};

}  // namespace omni::support
