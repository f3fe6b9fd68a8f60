// TELEMETRY of a tick from the control steps in it: their currents, the mean voltages, the newest Hall samples.
#pragma once

#include "firmware/core/safety/coil_heat.h"
#include "firmware/core/safety/hall_watch.h"

namespace omni::firmware {

class TickReport {
 public:
  // `end_A`: current at the end of the step that `inputs` reports.
  void Add(const Inputs& inputs, const float (&end_A)[wire::kCoils], const HallVerdict& hall,
           const Outputs& outputs) noexcept;

  // Electrical means, samples with their ages, temperatures; begins the next tick. The core adds its own fields.
  // Returns the instant of the newest Hall sample; it never goes back.
  std::uint64_t FillTelemetry(const Settings& settings, const Inputs& inputs, const HallWatch& hall,
                              const CoilHeat& heat, wire::Telemetry& telemetry) noexcept;

 private:
  void TakeField(const Inputs& inputs, const HallWatch& hall, wire::Telemetry& telemetry) noexcept;

  std::int16_t current_[kStepsPerTick][wire::kCoils] = {};
  std::int32_t voltage_[wire::kCoils] = {}, duty_[wire::kCoils] = {};
  int steps_ = 0;
  std::uint8_t fresh_ = 0;
  std::uint64_t t_device_us_ = 0;
};

}  // namespace omni::firmware
