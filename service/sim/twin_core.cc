#include "service/sim/twin_core.h"

#include <algorithm>
#include <cstring>

#include "firmware/wire/scaling.h"

namespace omni::sim {
namespace {

constexpr std::uint16_t kFirmwareVersion = 0x0001;

Imperfections Draw(const TwinOptions& options, Random& random) noexcept {
  return options.imperfect ? DrawImperfections(options.truth.imperfections, random) : Imperfections{};
}

base::TruthEffects Effects(const TwinOptions& options) noexcept {
  return options.imperfect ? options.truth.effects : base::TruthEffects{};
}

Vec3 ToVec3(const CoilArray& values) noexcept { return {values[0], values[1], values[2]}; }

}  // namespace

TwinCore::TwinCore(const base::DeviceGeometry& device, const TwinOptions& options)
    : device_(device),
      random_(options.seed),
      imperfections_(Draw(options, random_)),
      truth_(device, imperfections_, options.flip_coil_sign),
      drive_(device, options.truth.driver, options.truth.thermal, imperfections_),
      hand_(options.script, device, random_),
      sampler_(device, Effects(options), options.truth.sensor, truth_, {hand_.pose(), hand_.present(), {}},
               ~options.seed, 0, random_),
      surroundings_(sampler_.Now(0)) {}

wire::Hello TwinCore::Hello() const noexcept {
  wire::Hello hello;
  hello.firmware_version = kFirmwareVersion;
  hello.capabilities = wire::kDeviceClockIsHostMonotonic | wire::kSimulation | wire::kCurrentSensors;
  constexpr char kSerial[] = "twin";
  std::memcpy(hello.serial, kSerial, sizeof kSerial);
  hello.field_lsb_T = static_cast<float>(device_.sensor_lsb_T);
  hello.field_full_scale = sampler_.hall().full_scale();
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
  sampler_.Sample(surroundings_, random_);
  Report();
}

// The force map is taken once, at the pose expected in the middle of the tick (midpoint rule); within a millisecond
// the pen moves less than the map changes. Currents, spring and hull act in every sub-step.
void TwinCore::Advance() noexcept {
  sampler_.Begin();
  const double start_s = static_cast<double>(now_ns_) * 1e-9;
  surroundings_ = sampler_.Now(start_s);
  forces_ = hand_.present() ? truth_.ForcesAt(hand_.Predicted(start_s + 0.5 * base::kTickPeriod_s)) : ForceMap{};
  for (int i = 0; i < TickSampler::kSubSteps; ++i) {
    const double t_s = static_cast<double>(now_ns_) * 1e-9;
    now_ns_ += TickSampler::kSubStep_ns;
    drive_.Step(now_ns_, TickSampler::kSubStep_s);
    hand_.Step(t_s, TickSampler::kSubStep_s, forces_.Force(drive_.current_A(), surroundings_));
    sampler_.Add({hand_.pose(), hand_.present(), drive_.current_A()}, surroundings_);
  }
  surroundings_ = sampler_.Now(start_s);
}

void TwinCore::Report() noexcept {
  newest_sample_ns_ = sampler_.hall().Report(telemetry_);
  const CoilArray measured_A = drive_.Measured(sampler_.MeanCurrent());
  bool driving = false;
  for (std::size_t k = 0; k < measured_A.size(); ++k) {
    telemetry_.current[k] = wire::ToCounts<std::int16_t>(measured_A[k], wire::kCurrentUnit_A);
    telemetry_.temperature[k] = wire::ToCounts<std::int16_t>(drive_.temperature_C()[k], wire::kTemperatureUnit_K);
    driving = driving || drive_.set_point_A()[k] != 0;
  }
  telemetry_.supply = wire::ToCounts<std::uint16_t>(device_.supply_V, wire::kSupplyUnit_V);
  telemetry_.faults = drive_.faults();
  telemetry_.state = telemetry_.faults != 0 ? wire::State::kFault : driving ? wire::State::kArmed : wire::State::kIdle;
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
  row.coil_force_N = surroundings_.magnet_scale * forces_.CoilForce(drive_.current_A());
  row.force_N = forces_.Force(drive_.current_A(), surroundings_);
  row.gap_m = hand_.gap_m();
  row.command_age_s = command_age_s_;
  row.faults = drive_.faults();
  return row;
}

}  // namespace omni::sim
