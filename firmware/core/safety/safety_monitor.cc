#include "firmware/core/safety/safety_monitor.h"

#include "firmware/core/numbers.h"

namespace omni::firmware {
namespace {

constexpr int kWhole = wire::kSensors;

}  // namespace

void SafetyMonitor::Check(wire::Fault fault, int part, bool holds, float value) noexcept {
  const int index = IndexOf(fault);
  std::uint16_t& held = held_[index][part];
  if (!holds) {
    held = 0;
    return;
  }
  if (held < kFaultRules[index].hold) ++held;
  if (held == kFaultRules[index].hold) Report(fault, part, value);
}

void SafetyMonitor::ForgetCauses() noexcept {
  if (++cause_steps_ < kCauseGone_steps) return;
  cause_steps_ = 0;
  causes_before_ = causes_;
  causes_ = 0;
}

void SafetyMonitor::Report(wire::Fault fault, int part, float value) noexcept {
  if (count_ == kFindingsMax) return;
  findings_[count_++] = {fault, part == kWhole ? kWholeBase : static_cast<std::uint8_t>(part), value};
}

void SafetyMonitor::Step(const Settings& settings, const Observation& seen, const CoilHeat& heat,
                         const Drive& drive) noexcept {
  count_ = 0;
  ForgetCauses();
  Check(wire::kFaultEmergencyStop, kWhole, seen.emergency_stop, 1);
  Block(wire::kFaultEmergencyStop, seen.emergency_stop);
  Check(wire::kFaultInternal, kWhole, !seen.clock_advances, 0);
  Block(wire::kFaultInternal, !seen.clock_advances);
  CheckCoils(settings, seen, drive);
  for (int k = 0; k < wire::kCoils; ++k) CheckModel(k, settings, seen, heat, drive);
  CheckSupply(settings, seen);
  CheckHeat(settings, seen, heat);
  CheckHall(seen);
}

void SafetyMonitor::CheckCoils(const Settings& settings, const Observation& seen, const Drive& drive) noexcept {
  const bool was_asleep = drive.asleep_steps() > kAsleepSettled_steps;
  float power_W = 0;
  for (int k = 0; k < wire::kCoils; ++k) {
    const float current_A = Abs(seen.current_A[k]);
    const float voltage_V = seen.voltage_V[k];
    power_W += current_A * voltage_V;
    Check(wire::kFaultOverCurrent, k, !(current_A <= settings.current_trip_A), seen.current_A[k]);
    Block(wire::kFaultOverCurrent, !(current_A <= settings.current_trip_A));
    Check(wire::kFaultDriver, k, TestBit(seen.driver_fault, k), seen.current_A[k]);

    const bool is_nonsense = !(current_A <= kCurrentNonsense_A) || (was_asleep && current_A > kCurrentAsleep_A) ||
                             !(voltage_V <= kVoltageOverSupplyShare * seen.supply_V + kVoltageOverSupply_V);
    const bool is_wrong = !TestBit(seen.measured_mask, k) || is_nonsense;
    Check(wire::kFaultCurrentSensor, k, is_wrong && seen.state != wire::State::kBoot, seen.current_A[k]);
    Block(wire::kFaultCurrentSensor, is_wrong);
  }
  Block(wire::kFaultDriver, seen.driver_fault != 0);
  power_W_ += kStep_s / kPowerFilter_s * (power_W - power_W_);
  Check(wire::kFaultPower, kWhole, !(power_W_ <= kPowerTrip * settings.power_max_W), power_W_);
  Block(wire::kFaultPower, !(power_W_ <= settings.power_max_W));
}

// (7.1) to (7.3): the current that the measured voltage produces against the measured one; and that against the
// expected.
void SafetyMonitor::CheckModel(int coil, const Settings& settings, const Observation& seen, const CoilHeat& heat,
                               const Drive& drive) noexcept {
  const float resistance_ohm = heat.resistance_ohm(coil);
  const float r_20C_ohm = settings.coils[coil].resistance_20C_ohm;
  const bool is_driven = drive.follows() || drive.phase() == Drive::Phase::kTest;
  const bool is_known = TestBit(seen.measured_mask, coil);
  const CoilModel model(resistance_ohm, settings.coils[coil].inductance_H);
  const float before_A = model_A_[coil];
  const float after_A = model.NextCurrent_A(before_A, drive.direction(coil) * seen.voltage_V[coil]);
  model_A_[coil] = drive.is_asleep() ? 0 : after_A;
  const float given_A = 0.5F * (before_A + after_A);
  const float current_A = seen.current_A[coil];
  const float size_A = Abs(current_A);

  const bool is_open = is_driven && is_known && Abs(given_A) > kOpenCurrent_A && size_A < kOpenShare * Abs(given_A);
  Check(wire::kFaultCoilOpen, coil, is_open, current_A);
  const float same_way_A = Max(current_A < 0 ? -given_A : given_A, 0);
  const bool is_short = is_driven && is_known && size_A > kShortShare * same_way_A + kShortCurrent_A;
  Check(wire::kFaultCoilShort, coil, is_short, current_A);

  const float expected_A = drive.expected_A(coil);
  const float allowed_A = Max(kModelCurrent_A, kModelShare * Abs(expected_A));
  const bool is_off = drive.follows() && is_known && !(Abs(expected_A - current_A) <= allowed_A);
  const bool is_cold = !(resistance_ohm >= kResistanceShareMin * r_20C_ohm);
  Check(wire::kFaultModel, coil, is_off || is_cold, is_off ? current_A - expected_A : resistance_ohm);
}

// Without supply the sensors can still be tested: low counts where coils are, or may be, driven.
void SafetyMonitor::CheckSupply(const Settings& settings, const Observation& seen) noexcept {
  const bool counts = seen.state != wire::State::kBoot && (seen.state != wire::State::kSelfTest || seen.drives_test);
  Check(wire::kFaultSupplyLow, kWhole, counts && !(seen.supply_V >= settings.supply_min_V), seen.supply_V);
  Block(wire::kFaultSupplyLow, !(seen.supply_V >= settings.supply_min_V + kSupplyMargin_V));
  Check(wire::kFaultSupplyHigh, kWhole, !(seen.supply_V <= settings.supply_max_V), seen.supply_V);
  Block(wire::kFaultSupplyHigh, !(seen.supply_V <= settings.supply_max_V - kSupplyMargin_V));
}

void SafetyMonitor::CheckHeat(const Settings& settings, const Observation& seen, const CoilHeat& heat) noexcept {
  for (int k = 0; k < wire::kCoils; ++k) {
    const float temperature_C = heat.temperature_C(k);
    Check(wire::kFaultOverTemperature, k, !(temperature_C < settings.temperature_max_C), temperature_C);
    Block(wire::kFaultOverTemperature, !(temperature_C < settings.temperature_derate_C));
  }
  Check(wire::kFaultOverTemperature, kWhole, !(seen.board_C < kBoardMax_C), seen.board_C);
  Block(wire::kFaultOverTemperature, !(seen.board_C < kBoardCool_C));

  const bool should_turn = seen.fan >= kFanIdle && seen.supply_V >= settings.supply_min_V;
  const bool stands = should_turn && !(seen.fan_rpm >= static_cast<float>(kFanStands_rpm));
  Check(wire::kFaultFan, kWhole, stands, seen.fan_rpm);
  Block(wire::kFaultFan, stands);
}

void SafetyMonitor::CheckHall(const Observation& seen) noexcept {
  const bool has_started = seen.state != wire::State::kBoot;
  for (int i = 0; i < wire::kSensors; ++i) {
    Check(wire::kFaultHallSensor, i, has_started && TestBit(seen.hall.silent, i), 0);
    // The hall watch has counted its samples already.
    if (TestBit(seen.hall.stuck, i)) Report(wire::kFaultHallStuck, i, 0);
    if (TestBit(seen.hall.jumps, i)) Report(wire::kFaultHallJump, i, 0);
  }
  Block(wire::kFaultHallSensor, seen.hall.silent != 0);
  Block(wire::kFaultHallStuck, seen.hall.stuck != 0);
  Block(wire::kFaultHallJump, seen.hall.jumps != 0);
}

}  // namespace omni::firmware
