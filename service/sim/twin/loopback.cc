#include "service/sim/twin/loopback.h"

#include <array>

#include "service/device/commands.h"

namespace omni::sim {
namespace {

constexpr int kSilentTicksMax = 100;  // then the host sees the previous scan again

}  // namespace

Loopback::Loopback(const base::DeviceGeometry& device, const PlantOptions& options)
    : core_(device, options, kClockStart_ns) {
  device_.field_lsb_T = static_cast<double>(static_cast<float>(device.sensor_lsb_T));
  device_.current_max_A = device.current_max_A;
}

void Loopback::Tick(base::HallScan& scan) noexcept {
  int ticks = 0;
  do {
    SendArm();
    core_.Tick();
  } while (!TakeFrames(scan) && ++ticks < kSilentTicksMax);
}

bool Loopback::Write(const base::CoilCurrents& currents) noexcept {
  wire::Command command;
  command.mode = wire::Mode::kCurrent;
  command.host_us = static_cast<std::uint64_t>(Now_ns() / 1000);
  for (std::size_t k = 0; k < base::kCoilCount; ++k) command.set_point_A[k] = static_cast<float>(currents.current_A[k]);
  command.time_to_live_ms = device::TimeToLive_ms(command.set_point_A);
  std::array<std::uint8_t, wire::FrameSize<wire::Command>()> frame;
  const wire::Encoded encoded =
      wire::EncodeCommand(command, static_cast<float>(device_.current_max_A), command_seq_, frame.data(), frame.size());
  if (encoded.status != wire::Status::kOk) return false;
  response_.OnSent(command_seq_++, newest_device_us_);
  core_.Receive(frame.data(), encoded.size);
  return true;
}

void Loopback::SendArm() noexcept {
  wire::Arm arm;
  if (!arming_.NextToSend(Now_ns(), arm)) return;
  std::array<std::uint8_t, wire::FrameSize<wire::Arm>()> frame;
  const wire::Encoded encoded = wire::Encode(arm, arm_seq_++, 0, frame.data(), frame.size());
  core_.Receive(frame.data(), encoded.size);
}

bool Loopback::TakeFrames(base::HallScan& scan) noexcept {
  bool arrived = false;
  std::array<std::uint8_t, wire::kFrameSizeMax> frame;
  for (std::size_t size = 0; (size = core_.NextFrame(frame.data(), frame.size())) != 0;) {
    wire::FrameView view;
    wire::Telemetry telemetry;
    wire::Arm arm;
    if (wire::OpenFrame(frame.data(), size, view) != wire::Status::kOk) continue;
    if (wire::Decode(view, telemetry) == wire::Status::kOk) {
      arming_.OnTelemetry(telemetry, Now_ns());
      response_.OnTelemetry(telemetry);
      newest_device_us_ = view.header.t_device_us;
      scan = device::ScanFromTelemetry(device_, telemetry, newest_device_us_, core_.tick());
      scan.response_ns = response_.late_ns();
      arrived = true;
    } else if (wire::Decode(view, arm) == wire::Status::kOk) {
      arming_.OnArm(arm, Now_ns());
    }
  }
  return arrived;
}

}  // namespace omni::sim
