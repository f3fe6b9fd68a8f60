#include "firmware/core/drive.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "firmware/wire/messages.h"

namespace omni::firmware {
namespace {

constexpr int kBrake_steps = 10 * kStepsPerMs;
// Of the supply: the rest is for bridges, cables, and a supply that sags within the step.
constexpr float kVoltageUse = 0.97F;
// Share of the distance to a set-point per step: rounds the corner at which a wrong inductance would overshoot.
constexpr float kApproach = 0.7F;
// Coils that reverse feed the supply's capacitors. Limiting begins this far below the supply's upper limit and is
// complete this far below it: currents then fall as fast as braking allows.
constexpr float kFeedFrom_V = 3;
constexpr float kFeedTo_V = 1;
constexpr float kSupplyUsable_V = 1;  // below: no duty

// (6.2): from 1 at the temperature where currents shrink to 0 where they trip.
float DerateShare(const Settings& settings, float temperature_C) noexcept {
  const float span_K = settings.temperature_max_C - settings.temperature_derate_C;
  return Clamp((settings.temperature_max_C - temperature_C) / span_K, 0, 1);
}

// (2.6)
float FeedShare(const Settings& settings, float supply_V) noexcept {
  return Clamp((settings.supply_max_V - kFeedTo_V - supply_V) / (kFeedFrom_V - kFeedTo_V), 0, 1);
}

}  // namespace

void Drive::Enter(Phase phase) noexcept {
  phase_ = phase;
  in_phase_ = 0;
}

void Drive::Wake() noexcept {
  for (CurrentControl& control : controls_) control.Reset();
  Enter(Phase::kWake);
}

void Drive::Stop(Reaction reaction) noexcept {
  if (phase_ == Phase::kAsleep || phase_ == Phase::kBrake) return;
  if (reaction == Reaction::kRamp && phase_ == Phase::kRamp) return;
  if (reaction != Reaction::kRamp || phase_ != Phase::kControl) return Enter(Phase::kBrake);
  for (int k = 0; k < wire::kCoils; ++k) ramp_A_[k] = Abs(controls_[k].reference_A()) / kRamp_steps;
  Enter(Phase::kRamp);
}

void Drive::Panic() noexcept {
  for (CurrentControl& control : controls_) control.Reset();
  for (std::int16_t& duty : duty_) duty = 0;
  Enter(Phase::kBrake);
}

bool Drive::is_finite() const noexcept {
  for (const CurrentControl& control : controls_) {
    if (!IsFinite(control.reference_A()) || !IsFinite(control.expected_A()) || !IsFinite(control.integral_V())) {
      return false;
    }
  }
  return true;
}

void Drive::Step(const Settings& settings, const CoilHeat& heat, const Demand& demand, Outputs& outputs) noexcept {
  if (in_phase_ < std::numeric_limits<int>::max()) ++in_phase_;
  if (phase_ == Phase::kTest) Enter(Phase::kBrake);
  if (phase_ == Phase::kWake && in_phase_ > kWake_steps) Enter(Phase::kControl);
  if (phase_ == Phase::kRamp && in_phase_ > kRamp_steps) Enter(Phase::kBrake);
  if (phase_ == Phase::kBrake && in_phase_ > kBrake_steps) Enter(Phase::kAsleep);
  if (follows()) {
    Control(settings, heat, demand);
  } else {
    for (CurrentControl& control : controls_) control.Reset();
    for (std::int16_t& duty : duty_) duty = 0;
  }
  Write(outputs);
}

void Drive::StepTest(const float (&voltage_V)[wire::kCoils], bool awake, float supply_V, Outputs& outputs) noexcept {
  const Phase phase = awake ? Phase::kTest : Phase::kAsleep;
  if (phase_ != phase) Enter(phase);
  if (in_phase_ < std::numeric_limits<int>::max()) ++in_phase_;
  for (int k = 0; k < wire::kCoils; ++k) SetDuty(k, awake ? voltage_V[k] : 0, supply_V);
  Write(outputs);
}

// (6.1) to (6.3): limits of the set-points, then the coils one by one.
void Drive::Control(const Settings& settings, const CoilHeat& heat, const Demand& demand) noexcept {
  float target_A[wire::kCoils] = {};
  float power_W = 0;
  for (int k = 0; k < wire::kCoils; ++k) {
    const float limit_A = settings.current_max_A * DerateShare(settings, heat.temperature_C(k));
    target_A[k] = phase_ == Phase::kRamp ? 0 : Clamp(demand.set_point_A[k], -limit_A, limit_A);
    power_W += target_A[k] * target_A[k] * heat.resistance_ohm(k);
  }
  const float share = power_W > settings.power_max_W ? std::sqrt(settings.power_max_W / power_W) : 1;
  for (int k = 0; k < wire::kCoils; ++k) {
    const CoilModel model(heat.resistance_ohm(k), settings.coils[k].inductance_H);
    CurrentRequest request;
    request.target_A = share * target_A[k];
    request.slew_A = phase_ == Phase::kRamp ? ramp_A_[k] : settings.slew_max_A_s * kStep_s;
    request.approach = phase_ == Phase::kRamp ? 1 : kApproach;
    request.voltage_max_V = kVoltageUse * demand.supply_V;
    request.against = FeedShare(settings, demand.supply_V);
    request.measured_A = demand.measured_A[k];
    request.is_measured = ((demand.measured_mask >> k) & 1U) != 0;
    SetDuty(k, controls_[k].Step(model, request), demand.supply_V);
  }
}

// (6.4)
void Drive::SetDuty(int coil, float voltage_V, float supply_V) noexcept {
  duty_[coil] = 0;
  if (!(supply_V >= kSupplyUsable_V)) return;
  const float duty = Clamp(voltage_V / supply_V, -1, 1);
  if (!IsFinite(voltage_V)) return;
  duty_[coil] = wire::ToCounts<std::int16_t>(static_cast<double>(duty * static_cast<float>(wire::kDutyFull)), 1);
}

void Drive::Write(Outputs& outputs) const noexcept {
  for (int k = 0; k < wire::kCoils; ++k) outputs.duty[k] = duty_[k];
  outputs.awake = is_asleep() ? 0 : (1U << wire::kCoils) - 1;
}

}  // namespace omni::firmware
