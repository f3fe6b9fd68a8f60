// The twin in virtual time: Read() is the clock.
#include <cmath>
#include <utility>

#include "service/device/command_life.h"
#include "service/device/counters.h"
#include "service/device/scan_conversion.h"
#include "service/sim/twin_core.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kClockStart_ns = 1'000'000'000;  // stamps start at 1 s: 0 stays "never"

class VirtualTwin final : public device::Transport {
 public:
  VirtualTwin(const base::DeviceGeometry& device, const TwinOptions& options, double duration_s)
      : core_(device, options), ticks_(static_cast<std::uint64_t>(std::llround(duration_s / base::kTickPeriod_s))) {
    const wire::Hello hello = core_.Hello();
    device_.field_lsb_T = static_cast<double>(hello.field_lsb_T);
    device_.current_max_A = static_cast<double>(hello.current_max_A);
    info_ = {.name = "twin (simulation, virtual time)", .serial = "twin", .simulation = true, .virtual_time = true};
    if (options.recording_path.empty()) return;
    base::Result<std::unique_ptr<Recording>> recording = Recording::Open(options.recording_path);
    if (recording) {
      recording_ = std::move(recording.value());
    } else {
      std::fprintf(stderr, "%s\n", recording.error().c_str());
    }
  }

  device::ReadStatus Read(base::HallScan& scan, std::int64_t /*timeout_ns*/) noexcept override {
    if (core_.tick() >= ticks_) return device::ReadStatus::kEnd;
    core_.Tick(static_cast<double>(core_.tick() - command_tick_) * base::kTickPeriod_s);
    if (recording_) recording_->Add(core_.Truth(kClockStart_ns));
    const auto t_us = static_cast<std::uint64_t>((core_.newest_sample_ns() + kClockStart_ns) / 1000);
    scan = device::ScanFromTelemetry(device_, core_.telemetry(), t_us, core_.tick());
    ++counters_.received;
    return device::ReadStatus::kScan;
  }

  bool Write(const base::CoilCurrents& currents) noexcept override {
    wire::Command command;
    command.mode = wire::Mode::kCurrent;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      command.set_point_A[k] = static_cast<float>(currents.current_A[k]);
    }
    command.time_to_live_ms = device::TimeToLive_ms(command.set_point_A);
    if (wire::CheckCommand(command, static_cast<float>(device_.current_max_A)) != wire::Status::kOk) {
      ++counters_.send_failed;
      return false;
    }
    core_.Command(command, static_cast<std::uint16_t>(counters_.sent.value()));
    command_tick_ = core_.tick();
    ++counters_.sent;
    return true;
  }

  const device::TransportInfo& info() const noexcept override { return info_; }
  device::TransportCounters counters() const noexcept override { return counters_.Snapshot(); }

 private:
  TwinCore core_;
  std::uint64_t ticks_;
  std::uint64_t command_tick_ = 0;
  device::DeviceInfo device_;
  device::TransportInfo info_;
  device::Counters counters_;
  std::unique_ptr<Recording> recording_;
};

}  // namespace

std::unique_ptr<device::Transport> MakeVirtualTwin(const base::DeviceGeometry& device, const TwinOptions& options,
                                                   double duration_s) {
  return std::make_unique<VirtualTwin>(device, options, duration_s);
}

}  // namespace omni::sim
