#include "service/sim/twin_core.h"

#include <algorithm>
#include <cstring>

#include "firmware/wire/scaling.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kSubStep_ns = base::kTickPeriod_ns / 4;
constexpr double kSubStep_s = base::kTickPeriod_s / 4;
constexpr std::uint16_t kFirmwareVersion = 0x0001;

Imperfections Draw(const TwinOptions& options, Random& random) noexcept {
  return options.imperfect ? DrawImperfections(options.sizes, random) : Imperfections{};
}

Vec3 ToVec3(const CoilArray& values) noexcept { return {values[0], values[1], values[2]}; }

}  // namespace

TwinCore::TwinCore(const base::DeviceGeometry& device, const TwinOptions& options)
    : device_(device),
      random_(options.seed),
      imperfections_(Draw(options, random_)),
      truth_(device, imperfections_, options.flip_coil_sign),
      drive_(device, DriveConfig{options.current_delay_s, options.host_timeout_s}, ThermalConfig{}, imperfections_),
      hall_(device, random_),
      hand_(options.script, device, random_) {
  snapshots_.fill({hand_.pose(), hand_.present(), {}});
}

wire::Hello TwinCore::Hello() const noexcept {
  wire::Hello hello;
  hello.firmware_version = kFirmwareVersion;
  hello.capabilities = wire::kDeviceClockIsHostMonotonic | wire::kSimulation | wire::kCurrentSensors;
  constexpr char kSerial[] = "twin";
  std::memcpy(hello.serial, kSerial, sizeof kSerial);
  hello.field_lsb_T = static_cast<float>(device_.sensor_lsb_T);
  hello.field_full_scale = hall_.full_scale();
  hello.current_max_A = static_cast<float>(device_.current_max_A);
  return hello;
}

void TwinCore::Command(const wire::Command& command, std::uint16_t seq) noexcept {
  CoilArray set_point_A{};
  if (command.mode == wire::Mode::kCurrent) {
    std::copy(std::begin(command.set_point_A), std::end(command.set_point_A), set_point_A.begin());
  }
  drive_.Command(set_point_A, command.time_to_live_ms * 1e-3, now_ns_);
  telemetry_.ack_seq = seq;
  telemetry_.ack_host_us = command.host_us;
}

void TwinCore::Tick(double host_silence_s) noexcept {
  command_age_s_ = host_silence_s + base::kTickPeriod_s;
  drive_.Watch(host_silence_s);
  Advance();
  drive_.Heat(base::kTickPeriod_s);
  ++tick_;
  SampleSensors();
  Report();
}

// The force map is taken once, at the pose expected in the middle of the tick (midpoint rule); within a millisecond
// the pen moves less than the map changes. Currents, spring and hull act in every sub-step.
void TwinCore::Advance() noexcept {
  snapshots_.front() = snapshots_.back();
  const double start_s = static_cast<double>(now_ns_) * 1e-9;
  forces_ = hand_.present() ? truth_.ForcesAt(hand_.Predicted(start_s + 0.5 * base::kTickPeriod_s)) : ForceMap{};
  mean_current_A_ = {};
  for (int i = 0; i < kSubSteps; ++i) {
    const double t_s = static_cast<double>(now_ns_) * 1e-9;
    now_ns_ += kSubStep_ns;
    drive_.Step(now_ns_, kSubStep_s);
    const CoilArray& current_A = drive_.current_A();
    for (std::size_t k = 0; k < current_A.size(); ++k) mean_current_A_[k] += current_A[k] / kSubSteps;
    hand_.Step(t_s, kSubStep_s, forces_.core.force_N + forces_.CoilForce(current_A));
    snapshots_[static_cast<std::size_t>(i) + 1] = {hand_.pose(), hand_.present(), current_A};
  }
}

// Linear between sub-steps: at 2 m/s and 50 m/s^2 within a micrometre.
TwinCore::Snapshot TwinCore::At(std::int64_t t_ns) const noexcept {
  const std::int64_t since_start_ns = std::max<std::int64_t>(0, t_ns - (now_ns_ - base::kTickPeriod_ns));
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(since_start_ns / kSubStep_ns), kSubSteps - 1);
  const double s = static_cast<double>(since_start_ns - static_cast<std::int64_t>(i) * kSubStep_ns) /
                   static_cast<double>(kSubStep_ns);
  const Snapshot& a = snapshots_[i];
  const Snapshot& b = snapshots_[i + 1];
  Snapshot between = b;
  between.pose.centre_base_m = a.pose.centre_base_m + s * (b.pose.centre_base_m - a.pose.centre_base_m);
  between.pose.axis_base = Normalised(a.pose.axis_base + s * (b.pose.axis_base - a.pose.axis_base));
  for (std::size_t k = 0; k < a.current_A.size(); ++k) {
    between.current_A[k] = a.current_A[k] + s * (b.current_A[k] - a.current_A[k]);
  }
  return between;
}

void TwinCore::SampleSensors() noexcept {
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    std::int64_t sample_ns = 0;
    if (!hall_.NextSample(i, now_ns_, sample_ns)) continue;
    const Snapshot state = At(sample_ns);
    const Vec3 reading_T = truth_.SensorField(i, state.present ? &state.pose : nullptr, state.current_A);
    hall_.Sample(i, sample_ns, reading_T, random_);
  }
}

void TwinCore::Report() noexcept {
  newest_sample_ns_ = hall_.Report(telemetry_);
  const CoilArray measured_A = drive_.Measured(mean_current_A_);
  bool driving = false;
  for (std::size_t k = 0; k < measured_A.size(); ++k) {
    telemetry_.current[k] = wire::ToCounts<std::int16_t>(measured_A[k], wire::kCurrentUnit_A);
    telemetry_.temperature[k] = wire::ToCounts<std::int16_t>(drive_.temperature_C()[k], wire::kTemperatureUnit_K);
    driving = driving || drive_.set_point_A()[k] != 0;
  }
  telemetry_.supply = wire::ToCounts<std::uint16_t>(device_.supply_V, wire::kSupplyUnit_V);
  telemetry_.faults = drive_.faults();
  telemetry_.state = telemetry_.faults != 0 ? wire::State::kFault
                     : driving              ? wire::State::kDriving
                                            : wire::State::kIdle;
}

TruthRow TwinCore::Truth(std::int64_t clock_offset_ns) const noexcept {
  TruthRow row;
  row.t_ns = now_ns_ + clock_offset_ns;
  row.present = hand_.present();
  row.magnet_m = hand_.pose().centre_base_m;
  row.axis = hand_.pose().axis_base;
  row.tip_m = row.magnet_m + device_.magnet.tip_offset_m * row.axis;
  row.velocity_m_s = hand_.velocity_base_m_s();
  row.current_A = ToVec3(drive_.current_A());
  row.set_point_A = ToVec3(drive_.set_point_A());
  row.temperature_C = ToVec3(drive_.temperature_C());
  row.coil_force_N = forces_.CoilForce(drive_.current_A());
  row.force_N = row.coil_force_N + forces_.core.force_N;
  row.gap_m = hand_.gap_m();
  row.command_age_s = command_age_s_;
  row.faults = drive_.faults();
  return row;
}

}  // namespace omni::sim
