#include "service/sim/twin/twin_core.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "firmware/wire/messages.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kBoot_ns = 400'000'000;  // self-test included
constexpr std::uint32_t kNonceSeed = 1;

firmware::Settings SettingsOf(const base::DeviceGeometry& device) noexcept {
  firmware::Settings settings;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    settings.coils[k] = {static_cast<float>(device.coils[k].resistance_20C_ohm),
                         static_cast<float>(device.coils[k].inductance_H)};
  }
  settings.current_max_A = static_cast<float>(device.current_max_A);
  settings.temperature_derate_C = static_cast<float>(device.temperature_derate_C);
  settings.temperature_max_C = static_cast<float>(device.temperature_max_C);
  settings.field_lsb_T = static_cast<float>(device.sensor_lsb_T);
  settings.field_full_scale = wire::ToCounts<std::uint16_t>(device.sensor_range_T, device.sensor_lsb_T);
  settings.capabilities |= wire::kDeviceClockIsHostMonotonic | wire::kSimulation;
  constexpr char kSerial[] = "twin";
  std::memcpy(settings.serial, kSerial, sizeof kSerial);
  return settings;
}

PlantOptions StartedEarly(PlantOptions options) {
  options.start_ns -= kBoot_ns;
  return options;
}

}  // namespace

PlantOptions PlantOptionsOf(const TwinOptions& options) {
  PlantOptions plant;
  plant.seed = options.seed;
  plant.script = options.script;
  plant.led = options.guide != nullptr;
  plant.imperfect = options.imperfect;
  plant.flip_coil_sign = options.flip_coil_sign;
  plant.truth = options.truth;
  return plant;
}

TwinCore::TwinCore(const base::DeviceGeometry& device, const PlantOptions& options, std::int64_t clock_offset_ns)
    : plant_(device, StartedEarly(options)),
      core_(SettingsOf(device), firmware::ResetCause::kPower, kNonceSeed, record_),
      clock_offset_ns_(std::max(clock_offset_ns, kBoot_ns - options.start_ns)),
      current_max_A_(static_cast<float>(device.current_max_A)),
      scan_lost_(options.imperfect ? options.truth.effects.room.scan_lost : 0),
      scan_late_(options.imperfect ? options.truth.effects.room.scan_late : 0),
      link_random_(options.seed ^ 0x3A7) {
  std::uint8_t frame[wire::kFrameSizeMax];
  while (plant_.now_ns() < options.start_ns) {
    Step();
    while (core_.NextFrame(frame, sizeof frame) != 0) continue;
  }
}

std::size_t TwinCore::NextFrame(std::uint8_t* frame, std::size_t capacity) noexcept {
  if (late_size_ > 0 && late_tick_ < tick_ && late_size_ <= capacity) {
    std::copy_n(late_.begin(), late_size_, frame);
    return std::exchange(late_size_, 0);
  }
  std::size_t size = 0;
  do size = core_.NextFrame(frame, capacity);
  while (size > 0 && IsHeldUp(frame, size));
  return size;
}

// Scans only: other requests are repeated by the host.
bool TwinCore::IsHeldUp(const std::uint8_t* frame, std::size_t size) noexcept {
  if (scan_lost_ + scan_late_ == 0) return false;
  wire::FrameView view;
  if (wire::OpenFrame(frame, size, view) != wire::Status::kOk) return false;
  if (view.header.type != wire::MessageType::kTelemetry) return false;
  const double chance = link_random_.Uniform();
  if (chance < scan_lost_) return true;
  if (!(chance < scan_lost_ + scan_late_) || size > late_.size()) return false;
  std::copy_n(frame, size, late_.begin());
  late_size_ = size;
  late_tick_ = tick_;
  return true;
}

void TwinCore::Step() noexcept {
  firmware::Inputs inputs = plant_.inputs();
  inputs.now_us = static_cast<std::uint64_t>(plant_.now_ns() + clock_offset_ns_) / 1000;
  core_.Step(inputs, outputs_);
  plant_.Step(outputs_);
}

void TwinCore::Receive(const std::uint8_t* frame, std::size_t size) noexcept {
  core_.Receive(frame, size);
  Peek(frame, size);
}

// The host's part of the recording.
void TwinCore::Peek(const std::uint8_t* frame, std::size_t size) noexcept {
  wire::FrameView view;
  wire::Command command;
  if (wire::OpenFrame(frame, size, view) != wire::Status::kOk) return;
  if (wire::DecodeCommand(view, current_max_A_, command) != wire::Status::kOk) return;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    host_.set_point_A[k] = command.mode == wire::Mode::kCurrent ? static_cast<double>(command.set_point_A[k]) : 0.0;
  }
  command_ns_ = plant_.now_ns();
}

void TwinCore::Tick() noexcept {
  for (int i = 0; i < firmware::kStepsPerTick; ++i) Step();
  ++tick_;
  host_.command_age_s = static_cast<double>(plant_.now_ns() - command_ns_) * 1e-9;
  host_.faults = core_.faults();
}

TruthRow TwinCore::Truth() const noexcept {
  HostView host = host_;
  if (core_.state() != wire::State::kArmed) host.set_point_A = {};
  return plant_.Truth(host, clock_offset_ns_);
}

}  // namespace omni::sim
