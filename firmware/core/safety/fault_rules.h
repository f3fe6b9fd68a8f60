// Every fault: how long its condition must hold, the coils' reaction, and what ARM requires. Thresholds that depend on
// the base (supply, temperatures, trip current) are in Settings; all others are defined here.
// docs/protocol/faults.md
#pragma once

#include <cstdint>

#include "firmware/core/numbers.h"

namespace omni::firmware {

// The coils' reaction to a fault. Ramp and brake both end with bridges that brake for 10 ms and then sleep.
enum class Reaction : std::uint8_t {
  kNone,   // the coils are at zero anyway
  kRamp,   // the currents can still be controlled: to zero within 5 ms
  kBrake,  // they cannot, or there is no time: windings shorted, time constant L/R
};

// Parts of the self-test that a fault invalidates: ARM runs it again before anything else.
constexpr std::uint8_t kRetestHall = 1U << 0;
constexpr std::uint8_t kRetestCoils = 1U << 1;

using wire::kWholeBase;

struct FaultRule {
  wire::Fault fault;
  Reaction reaction;
  std::uint8_t retest;
  std::uint16_t hold;  // steps (samples, where it is a Hall sensor's) in a row
};

constexpr std::uint16_t Steps(float milliseconds) {
  return static_cast<std::uint16_t>(milliseconds * static_cast<float>(kStepsPerMs));
}

constexpr FaultRule kFaultRules[] = {
    {wire::kFaultNotArmed, Reaction::kNone, 0, 1},
    {wire::kFaultHostSilent, Reaction::kRamp, 0, 1},
    {wire::kFaultOverTemperature, Reaction::kRamp, 0, Steps(20)},
    {wire::kFaultOverCurrent, Reaction::kBrake, kRetestCoils, Steps(1)},
    {wire::kFaultDriver, Reaction::kBrake, kRetestCoils, 1},
    {wire::kFaultSupplyLow, Reaction::kBrake, 0, Steps(2)},
    {wire::kFaultSupplyHigh, Reaction::kBrake, 0, Steps(0.5F)},
    {wire::kFaultPower, Reaction::kRamp, kRetestCoils, Steps(1)},
    {wire::kFaultCoilOpen, Reaction::kBrake, kRetestCoils, Steps(2)},
    {wire::kFaultCoilShort, Reaction::kBrake, kRetestCoils, Steps(1.5F)},
    {wire::kFaultModel, Reaction::kBrake, kRetestCoils, Steps(10)},
    {wire::kFaultCurrentSensor, Reaction::kBrake, kRetestCoils, Steps(1)},
    {wire::kFaultHallSensor, Reaction::kRamp, kRetestHall, Steps(1)},
    {wire::kFaultHallStuck, Reaction::kRamp, 0, 15},
    {wire::kFaultHallJump, Reaction::kRamp, 0, 3},
    {wire::kFaultFan, Reaction::kRamp, 0, Steps(3000)},
    {wire::kFaultEmergencyStop, Reaction::kBrake, 0, Steps(0.5F)},
    {wire::kFaultSelfTest, Reaction::kBrake, kRetestHall | kRetestCoils, 1},
    {wire::kFaultWatchdog, Reaction::kNone, 0, 1},
    {wire::kFaultInternal, Reaction::kBrake, kRetestHall | kRetestCoils, 1},
};
constexpr int kFaultCount = sizeof kFaultRules / sizeof kFaultRules[0];

namespace internal {
constexpr bool RulesAreInOrder() {
  for (int i = 0; i < kFaultCount; ++i) {
    if (kFaultRules[i].fault != (1U << i)) return false;
  }
  return true;
}
}  // namespace internal
static_assert(internal::RulesAreInOrder(), "rule i is that of bit i");

constexpr int IndexOf(std::uint32_t fault) noexcept {
  int index = 0;
  while (index + 1 < kFaultCount && (fault >> index) != 1U) ++index;
  return index;
}
constexpr const FaultRule& RuleOf(std::uint32_t fault) noexcept { return kFaultRules[IndexOf(fault)]; }

// A cause is gone once it has been absent for this long, or up to twice that: a bouncing contact, or a sensor that is
// right only now and then, keeps ARM refused all the time.
constexpr int kCauseGone_steps = 5 * kStepsPerMs;
// Supply: ARM requires it this far inside its limits, so that a supply at the edge does not alternately arm and trip.
constexpr float kSupplyMargin_V = 0.5F;
// Power: of electrical power over its limit; smoothed, because building up a field takes more for a millisecond.
constexpr float kPowerTrip = 1.1F;
constexpr float kPowerFilter_s = 10e-3F;
// Coil open: less than this share of the current that the measured voltage produces, where that is large enough. A pen
// that hits the hull induces 0.2 V per m/s, which the control cancels: voltage without current. 1 A is 3 m/s.
constexpr float kOpenShare = 0.25F;
constexpr float kOpenCurrent_A = 1;
// Coil short: more than this share of it plus this margin, larger than the self-test's ampere (its sign may be wrong).
constexpr float kShortShare = 1.5F;
constexpr float kShortCurrent_A = 1.5F;
// Model: this far from the step's expected current, whichever is larger.
constexpr float kModelShare = 0.2F;
constexpr float kModelCurrent_A = 1;
// Resistance: below this share of its value at 20 C (-31 C of copper) it is not a plausible temperature.
constexpr float kResistanceShareMin = 0.8F;
// Current sensor: beyond the range of its word (32767 * 1.25 mA) less 1 %, or more voltage than the supply has, or
// current through a bridge that has slept for 50 ms.
constexpr float kCurrentNonsense_A = 40.5F;
constexpr float kVoltageOverSupply_V = 2;
constexpr float kVoltageOverSupplyShare = 1.2F;
constexpr float kCurrentAsleep_A = 0.5F;
constexpr int kAsleepSettled_steps = 50 * kStepsPerMs;
// Hall: at 1 kHz five samples are missing.
constexpr std::uint32_t kHallStale_us = 5000;
// Hall jump: a magnet of 5.1 A m^2 moves at 2 m/s past a sensor that it almost saturates: 3 B v / r = 1.6 G per ms.
// Five times that; plus the coils' change: at most full scale for current_max_A (by the sensors' positions), and twice
// that for uncertainty.
constexpr float kHallJump_T = 8e-4F;
constexpr float kHallCoilDoubt = 2;
// Fan: turns at least at kFanIdle while there is supply, so that a dead one is detected before it is needed.
constexpr std::uint8_t kFanIdle = 64;
constexpr std::uint16_t kFanStands_rpm = 200;
constexpr float kFanFullFrom_C = 20;  // below the temperature at which currents shrink ...
constexpr float kFanFullAt_C = 0;     // ... it speeds up, to full speed there
// Ramp to zero: 4.5 ms; the remaining current decays within the specified 5 ms.
constexpr int kRamp_steps = 18;
// Bridges: from the end of sleep until they drive; DRV8701 data sheet, wake-up time: 1 ms at most.
constexpr int kWake_steps = 2 * kStepsPerMs;
// Board: bridges and micro-controller, by the board's own thermometer.
constexpr float kBoardMax_C = 85;
constexpr float kBoardCool_C = 75;  // required by ARM

}  // namespace omni::firmware
