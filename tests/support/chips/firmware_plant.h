// A simple, exact model of a base for the control core: coils over a step of constant mean voltage, copper that heats,
// current sensors with their errors, free-running Hall sensors with noise, a fan; and all failures of these parts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

#include "firmware/core/board_io.h"
#include "firmware/core/link/settings.h"
#include "firmware/wire/messages.h"

namespace omni::firmware {

struct FirmwarePlantFaults {
  bool hall_dead = false, hall_stuck = false, hall_jump = false;  // sensor 3
  bool hall_flutters = false;                                     // sensor 3: to another value every 4 samples
  bool test_field_dead = false, test_field_reversed = false;      // sensor 3
  bool current_sensor_dead = false, current_reversed = false;     // coil 1, as are all below
  std::optional<double> current_reading_A;
  std::optional<double> current_limit_A;  // a bridge that chops
  double voltage_reading = 1;             // gain of all voltage readings
  bool coil_open = false, coil_short = false;
  bool driver = false;
  bool emergency_stop = false;
  bool fan_stands = false;
  bool clock_stands = false;
  double board_C = 30;
};

class FirmwarePlant {
 public:
  struct Options {
    double supply_V = 18;
    double air_C = 24;
    double start_C = 24;
    double resistance_error = 0, inductance_error = 0;  // of the coils against Settings
    double current_gain = 1.0015, current_offset_A = 2e-3;
    std::uint64_t seed = 1;
  };

  FirmwarePlant(const Settings& settings, const Options& options)
      : settings_(settings), options_(options), random_(options.seed), body_C_(options.start_C) {
    for (double& copper_C : copper_C_) copper_C = options.start_C;
    for (double& phase_us : next_us_) phase_us = std::uniform_real_distribution<double>(0, 1000)(random_);
  }

  const Inputs& Step(const Outputs& outputs) {
    if (!faults.clock_stands) inputs_.now_us += kStepPeriod_us;
    real_us_ += kStepPeriod_us;
    inputs_.supply = wire::ToCounts<std::uint16_t>(options_.supply_V, wire::kSupplyUnit_V);
    for (int k = 0; k < wire::kCoils; ++k) StepCoil(k, outputs);
    Heat();
    inputs_.field_fresh = 0;
    for (int i = 0; i < wire::kSensors; ++i) SampleHall(i, outputs.hall_self_test != 0);
    const double wanted_rpm = faults.fan_stands ? 0 : 3000.0 * outputs.fan / 255;
    fan_rpm_ += (wanted_rpm - fan_rpm_) * kStep_s / 0.3;
    inputs_.fan_rpm = static_cast<std::uint16_t>(faults.fan_stands ? 0 : fan_rpm_);
    inputs_.board_temperature = wire::ToCounts<std::int16_t>(faults.board_C, wire::kTemperatureUnit_K);
    inputs_.emergency_stop = faults.emergency_stop ? 1 : 0;
    inputs_.driver_fault = faults.driver ? 2 : 0;
    return inputs_;
  }

  const Inputs& inputs() const { return inputs_; }
  double current_A(int coil) const { return current_A_[coil]; }
  double largest_A() const {
    return std::max({std::abs(current_A_[0]), std::abs(current_A_[1]), std::abs(current_A_[2])});
  }
  double resistance_ohm(int coil) const {
    const double nominal_ohm = static_cast<double>(settings_.coils[coil].resistance_20C_ohm);
    return nominal_ohm * (1 + options_.resistance_error) *
           (1 + static_cast<double>(settings_.resistance_per_K) * (copper_C_[coil] - 20));
  }
  double temperature_C(int coil) const { return copper_C_[coil]; }
  void SetTemperature(double all_C) {
    for (double& copper_C : copper_C_) copper_C = all_C;
    body_C_ = all_C;
  }
  void SetSupply(double supply_V) { options_.supply_V = supply_V; }

  FirmwarePlantFaults faults;

 private:
  static constexpr double kStep_s = 250e-6;

  // L di/dt = U - R i, exact for a constant voltage; asleep, the diodes turn the whole supply against the current.
  void StepCoil(int k, const Outputs& outputs) {
    const bool is_broken = k == 1;
    const bool is_short = is_broken && faults.coil_short;
    const double ohm = resistance_ohm(k) * (is_short ? 0.1 : 1);
    const double inductance_H =
        static_cast<double>(settings_.coils[k].inductance_H) * (1 + options_.inductance_error) * (is_short ? 0.1 : 1);
    const bool is_awake = ((outputs.awake >> k) & 1) != 0 && !(is_broken && faults.driver);
    const double before_A = current_A_[k];
    double voltage_V = options_.supply_V * outputs.duty[k] / wire::kDutyFull;
    if (!is_awake) voltage_V = before_A > 0 ? -options_.supply_V : options_.supply_V;
    const double final_A = voltage_V / ohm;
    const double tau_s = inductance_H / ohm;
    double after_A = final_A + (before_A - final_A) * std::exp(-kStep_s / tau_s);
    double mean_A = final_A - (after_A - before_A) * tau_s / kStep_s;
    if (!is_awake && (before_A == 0 || (after_A > 0) != (before_A > 0))) {
      after_A = 0;
      mean_A = 0.25 * before_A;
      voltage_V = 0;
    }
    if (is_broken && faults.coil_open) after_A = mean_A = 0;
    if (is_broken && faults.current_limit_A) {
      const double limit_A = *faults.current_limit_A;
      if (std::abs(after_A) > limit_A) {
        after_A = mean_A = std::copysign(limit_A, after_A);
        voltage_V = after_A * ohm;
      }
    }
    current_A_[k] = after_A;
    mean_square_A2_[k] = mean_A * mean_A;
    Report(k, mean_A, voltage_V);
  }

  void Report(int k, double mean_A, double voltage_V) {
    const bool is_broken = k == 1;
    const bool answers = !(is_broken && faults.current_sensor_dead);
    const auto bit = static_cast<std::uint8_t>(1U << k);
    inputs_.current_answers =
        static_cast<std::uint8_t>(answers ? inputs_.current_answers | bit : inputs_.current_answers & ~bit);
    if (!answers) return;
    double read_A = options_.current_gain * mean_A + options_.current_offset_A;
    if (is_broken && faults.current_reversed) read_A = -read_A;
    if (is_broken && faults.current_reading_A) read_A = *faults.current_reading_A;
    inputs_.current[k] = wire::ToCounts<std::int16_t>(read_A, wire::kCurrentUnit_A);
    inputs_.voltage[k] =
        wire::ToCounts<std::uint16_t>(faults.voltage_reading * std::abs(voltage_V), wire::kSupplyUnit_V);
  }

  void Heat() {
    const double to_body_W_K = static_cast<double>(settings_.copper_to_body_W_K);
    double into_body_W = -static_cast<double>(settings_.body_to_air_W_K) * (body_C_ - options_.air_C);
    for (int k = 0; k < wire::kCoils; ++k) {
      const double flow_W = to_body_W_K * (copper_C_[k] - body_C_);
      copper_C_[k] +=
          (mean_square_A2_[k] * resistance_ohm(k) - flow_W) * kStep_s / static_cast<double>(settings_.copper_J_K);
      into_body_W += flow_W;
    }
    body_C_ += into_body_W * kStep_s / static_cast<double>(settings_.body_J_K);
  }

  // Every sensor at 1 kHz by its own oscillator.
  void SampleHall(int i, bool test_field) {
    const bool is_broken = i == 3;
    const auto bit = static_cast<std::uint8_t>(1U << i);
    const bool answers = !(is_broken && faults.hall_dead);
    inputs_.field_answers =
        static_cast<std::uint8_t>(answers ? inputs_.field_answers | bit : inputs_.field_answers & ~bit);
    if (real_us_ >= next_us_[i]) {
      sampled_us_[i] = next_us_[i];
      next_us_[i] += 1000.0 + 0.6 * i;
      if (answers) {
        inputs_.field_fresh = static_cast<std::uint8_t>(inputs_.field_fresh | bit);
        if (!(is_broken && faults.hall_stuck)) Convert(i, test_field);
      }
    }
    inputs_.field_age_us[i] = static_cast<std::uint16_t>(std::clamp(real_us_ - sampled_us_[i], 0.0, 65535.0));
  }

  void Convert(int i, bool test_field) {
    constexpr double kTestField_T[] = {2e-4, 2e-4, 0.5e-4};
    constexpr double kPerAmpere_T = 5e-5;
    const bool is_broken = i == 3;
    if (is_broken) ++samples_;
    for (int axis = 0; axis < 3; ++axis) {
      double field_T = 1e-5 * (i + 1) * (axis - 1) + kPerAmpere_T * current_A_[axis];
      const bool shows = test_field && !(is_broken && faults.test_field_dead);
      if (shows) field_T += is_broken && faults.test_field_reversed ? -kTestField_T[axis] : kTestField_T[axis];
      if (is_broken && faults.hall_jump) field_T += 1.2e-3;
      if (is_broken && faults.hall_flutters && samples_ % 8 < 4) field_T += 1.2e-3;
      field_T += std::normal_distribution<double>(0, 8e-7)(random_);
      inputs_.field[i][axis] = wire::ToCounts<std::int16_t>(field_T, static_cast<double>(settings_.field_lsb_T));
    }
  }

  Settings settings_;
  Options options_;
  std::mt19937_64 random_;
  Inputs inputs_;
  double real_us_ = 0;
  double current_A_[wire::kCoils] = {};
  double mean_square_A2_[wire::kCoils] = {};
  double copper_C_[wire::kCoils] = {};
  double body_C_;
  double next_us_[wire::kSensors] = {};
  double sampled_us_[wire::kSensors] = {};
  double fan_rpm_ = 0;
  int samples_ = 0;  // of sensor 3
};

}  // namespace omni::firmware
