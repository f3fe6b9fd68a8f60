// A pen held still in the block of the extrusion scene (simulated), five times faster than real; stamps are of now.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>

#include "service/base/clock.h"
#include "service/config/files/device_file.h"
#include "service/device/transport.h"
#include "service/sim/twin/twin.h"

namespace omni::support {

class HeldPen : public device::Transport {
 public:
  HeldPen() {
    sim::TwinOptions options;
    options.script.waypoints = {{.duration_s = 0, .tip_base_m = {0.008, 0.004, 0.044}}};
    twin_ = sim::MakeVirtualTwin(config::DefaultDevice(), options, 1e6);
  }
  device::ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept override {
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    const device::ReadStatus status = twin_->Read(scan, timeout_ns);
    scan.t_ns = base::MonotonicNow_ns();
    return status;
  }
  bool Write(const base::CoilCurrents& currents) noexcept override { return twin_->Write(currents); }
  const device::TransportInfo& info() const noexcept override { return twin_->info(); }
  device::TransportCounters counters() const noexcept override { return twin_->counters(); }

 private:
  std::unique_ptr<device::Transport> twin_;
};

}  // namespace omni::support
