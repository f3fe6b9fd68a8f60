#include "firmware/core/link/tick_report.h"

#include "firmware/core/safety/fault_rules.h"
#include "firmware/wire/messages.h"

namespace omni::firmware {
namespace {

constexpr double kResistanceUnit_ohm = 1e-4;
constexpr std::uint64_t kAgeUnit_us = static_cast<std::uint64_t>(wire::kAgeUnit_ns) / 1000;
constexpr std::uint64_t kAgeMax = 255;
constexpr std::uint64_t kLeadMax_us = 65535;

std::int32_t RoundedMean(std::int32_t sum, int count) noexcept {
  return (sum >= 0 ? sum + count / 2 : sum - count / 2) / count;
}

}  // namespace

void TickReport::Add(const Inputs& inputs, const float (&end_A)[wire::kCoils], const HallVerdict& hall,
                     const Outputs& outputs) noexcept {
  const int step = steps_ < kStepsPerTick ? steps_ : kStepsPerTick - 1;
  for (int k = 0; k < wire::kCoils; ++k) {
    current_[step][k] = wire::ToCounts<std::int16_t>(static_cast<double>(end_A[k]), wire::kCurrentUnit_A);
    voltage_[k] += inputs.voltage[k];
    duty_[k] += outputs.duty[k];
  }
  fresh_ |= hall.fresh;
  ++steps_;
}

std::uint64_t TickReport::FillTelemetry(const Settings& settings, const Inputs& inputs, const HallWatch& hall,
                                        const CoilHeat& heat, wire::Telemetry& telemetry) noexcept {
  const int steps = steps_ > 0 ? steps_ : 1;
  for (int k = 0; k < wire::kCoils; ++k) {
    for (int step = 0; step < kStepsPerTick; ++step) telemetry.current[step][k] = current_[step][k];
    telemetry.voltage[k] = static_cast<std::uint16_t>(RoundedMean(voltage_[k], steps));
    telemetry.duty[k] = static_cast<std::int16_t>(RoundedMean(duty_[k], steps));
    telemetry.temperature[k] =
        wire::ToCounts<std::int16_t>(static_cast<double>(heat.temperature_C(k)), wire::kTemperatureUnit_K);
    telemetry.resistance[k] =
        wire::ToCounts<std::uint16_t>(static_cast<double>(heat.resistance_ohm(k)), kResistanceUnit_ohm);
    voltage_[k] = duty_[k] = 0;
  }
  steps_ = 0;
  telemetry.supply = inputs.supply;
  telemetry.board_temperature = inputs.board_temperature;
  telemetry.fan_rpm = inputs.fan_rpm;
  telemetry.saturated_mask = hall.saturated_mask(settings);
  telemetry.fresh_mask = fresh_;
  fresh_ = 0;
  TakeField(inputs, hall, telemetry);
  const std::uint64_t lead_us = inputs.now_us > t_device_us_ ? inputs.now_us - t_device_us_ : 0;
  telemetry.tick_lead = static_cast<std::uint16_t>(lead_us < kLeadMax_us ? lead_us : kLeadMax_us);
  return t_device_us_;
}

// If all samples are stale, the tick's own time.
void TickReport::TakeField(const Inputs& inputs, const HallWatch& hall, wire::Telemetry& telemetry) noexcept {
  std::uint64_t newest_us = 0;
  for (int i = 0; i < wire::kSensors; ++i) {
    if (hall.has_sample(i) && hall.sample_us(i) > newest_us) newest_us = hall.sample_us(i);
  }
  if (inputs.now_us - newest_us > kHallStale_us) newest_us = inputs.now_us;
  if (newest_us > t_device_us_) t_device_us_ = newest_us;
  for (int i = 0; i < wire::kSensors; ++i) {
    for (int axis = 0; axis < 3; ++axis) telemetry.field[i][axis] = hall.field(i)[axis];
    const std::uint64_t age = (t_device_us_ - hall.sample_us(i) + kAgeUnit_us / 2) / kAgeUnit_us;
    telemetry.age[i] = static_cast<std::uint8_t>(!hall.has_sample(i) || age > kAgeMax ? kAgeMax : age);
  }
}

}  // namespace omni::firmware
