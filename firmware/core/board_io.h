// Inputs and outputs of the control core, once per control step: raw words as the chips deliver them. The same two
// structs are used by drivers (firmware/board/teensy40), by an emulated board (mps2_an500), by the twin's plant and by
// tests. All fields have a fixed width and the same offsets on every target.
#pragma once

#include <cstdint>
#include <type_traits>

#include "firmware/wire/messages.h"

namespace omni::firmware {

constexpr std::uint32_t kStepPeriod_us = 250;  // control step, 4 kHz: as fast as three current sensors on I2C allow
constexpr int kStepsPerTick = wire::kStepsPerTick;  // telemetry, 1 kHz

struct Inputs {
  std::uint64_t now_us = 0;                         // since reset; never goes back
  std::int16_t field[wire::kSensors][3] = {};       // newest sample of each Hall sensor, counts
  std::uint16_t field_age_us[wire::kSensors] = {};  // of that sample at now_us; 65535: that or older
  std::int16_t current[wire::kCoils] = {};          // 1.25 mA (INA260), signed, mean over the step before
  std::uint16_t voltage[wire::kCoils] = {};         // 1.25 mV, across the coil, without sign
  std::uint16_t supply = 0;                         // 1.25 mV
  std::int16_t board_temperature = 0;               // 0.01 C
  std::uint16_t fan_rpm = 0;
  std::uint8_t field_fresh = 0;      // bit i: a new sample since the step before
  std::uint8_t field_answers = 0;    // bit i: sensor i answers, with its identity
  std::uint8_t current_answers = 0;  // bit k: current sensor k answers
  std::uint8_t driver_fault = 0;     // bit k: H bridge k reports a fault, or current sensor k its alert
  std::uint8_t emergency_stop = 0;   // 1: the switch is open (a broken wire stops too)
  std::uint8_t reserved[9] = {};
};
static_assert(std::is_trivially_copyable<Inputs>::value && sizeof(Inputs) == 104, "same layout everywhere");
static_assert(std::has_unique_object_representations<Inputs>::value,
              "no hidden padding: it is sent over links as it is");

struct Outputs {
  std::int16_t duty[wire::kCoils] = {};  // of wire::kDutyFull: mean voltage duty * supply; 0: brake
  std::uint8_t awake = 0;                // bit k: bridge k is awake; asleep it coasts into the supply
  std::uint8_t hall_self_test = 0;       // 1: the Hall sensors' own test field is on
  std::uint8_t fan = 0;                  // of 255
  std::uint8_t feed_watchdog = 0;        // 1: sensors, currents and control all ran
  std::uint8_t reserved[6] = {};
};
static_assert(std::is_trivially_copyable<Outputs>::value && sizeof(Outputs) == 16, "same layout everywhere");
static_assert(std::has_unique_object_representations<Outputs>::value, "likewise");

enum class ResetCause : std::uint8_t { kPower = 0, kWatchdog = 1, kSoftware = 2 };

}  // namespace omni::firmware
