// The twin in virtual time: Read() is the clock.
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "service/device/arming.h"
#include "service/device/counters.h"
#include "service/device/scan_conversion.h"
#include "service/sim/twin_core.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kClockStart_ns = 1'000'000'000;  // stamps start at 1 s: 0 stays "never"

// Frames go to and fro as over a wire, in no time.
class VirtualTwin final : public device::Transport {
 public:
  VirtualTwin(const base::DeviceGeometry& device, const TwinOptions& options, double duration_s)
      : core_(device, options, kClockStart_ns),
        ticks_(static_cast<std::uint64_t>(std::llround(duration_s / base::kTickPeriod_s))) {
    device_.field_lsb_T = static_cast<double>(static_cast<float>(device.sensor_lsb_T));
    device_.current_max_A = device.current_max_A;
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
    SendArm();
    core_.Tick();
    if (recording_) recording_->Add(core_.Truth());
    TakeFrames(scan);
    ++counters_.received;
    return device::ReadStatus::kScan;
  }

  bool Write(const base::CoilCurrents& currents) noexcept override {
    wire::Command command;
    command.mode = wire::Mode::kCurrent;
    command.host_us = static_cast<std::uint64_t>(Now_ns() / 1000);
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      command.set_point_A[k] = static_cast<float>(currents.current_A[k]);
    }
    std::array<std::uint8_t, wire::FrameSize<wire::Command>()> frame;
    const wire::Encoded encoded =
        wire::EncodeCommand(command, static_cast<float>(device_.current_max_A),
                            static_cast<std::uint16_t>(counters_.sent.value()), frame.data(), frame.size());
    if (encoded.status != wire::Status::kOk) {
      ++counters_.send_failed;
      return false;
    }
    core_.Receive(frame.data(), encoded.size);
    ++counters_.sent;
    return true;
  }

  const device::TransportInfo& info() const noexcept override { return info_; }
  device::TransportCounters counters() const noexcept override { return counters_.Snapshot(); }

 private:
  std::int64_t Now_ns() const noexcept { return core_.now_ns() + core_.clock_offset_ns(); }

  void SendArm() noexcept {
    wire::Arm arm;
    if (!arming_.Next(Now_ns(), arm)) return;
    std::array<std::uint8_t, wire::FrameSize<wire::Arm>()> frame;
    const wire::Encoded encoded = wire::Encode(arm, arm_seq_++, 0, frame.data(), frame.size());
    core_.Receive(frame.data(), encoded.size);
  }

  void TakeFrames(base::HallScan& scan) noexcept {
    std::array<std::uint8_t, wire::kFrameSizeMax> frame;
    for (std::size_t size = 0; (size = core_.NextFrame(frame.data(), frame.size())) != 0;) {
      wire::FrameView view;
      wire::Telemetry telemetry;
      wire::Arm arm;
      if (wire::OpenFrame(frame.data(), size, view) != wire::Status::kOk) continue;
      if (wire::Decode(view, telemetry) == wire::Status::kOk) {
        arming_.OnTelemetry(telemetry, Now_ns());
        scan = device::ScanFromTelemetry(device_, telemetry, view.header.t_device_us, core_.tick());
      } else if (wire::Decode(view, arm) == wire::Status::kOk) {
        arming_.OnArm(arm, Now_ns());
      }
    }
  }

  TwinCore core_;
  std::uint64_t ticks_;
  device::DeviceInfo device_;
  device::TransportInfo info_;
  device::Counters counters_;
  device::Arming arming_;
  std::uint16_t arm_seq_ = 0;
  std::unique_ptr<Recording> recording_;
};

}  // namespace

std::unique_ptr<device::Transport> MakeVirtualTwin(const base::DeviceGeometry& device, const TwinOptions& options,
                                                   double duration_s) {
  return std::make_unique<VirtualTwin>(device, options, duration_s);
}

}  // namespace omni::sim
