// One coil's current: a reference that the supply can always follow, the voltage that produces it according to the
// model, and a PI controller for the model's errors. docs/theory/firmware.md (2.1) to (2.5)
#pragma once

#include "firmware/core/numbers.h"

namespace omni::firmware {

// A coil as resistance and inductance over one control step of constant mean voltage. docs/theory/firmware.md (1.1) to
// (1.5)
class CoilModel {
 public:
  // Preconditions: both > 0 and finite.
  CoilModel(float resistance_ohm, float inductance_H) noexcept
      : resistance_ohm_(resistance_ohm),
        inductance_H_(inductance_H),
        step_in_tau_(resistance_ohm * kStep_s / inductance_H) {
    // (1.2): exp(-x) as a quotient of two polynomials; its relative error is below 1e-6 for x <= 0.3.
    const float x = step_in_tau_;
    const float even = 1 + x * x / 12;
    decay_ = (even - x / 2) / (even + x / 2);
  }

  // (1.1): current at the end of a step that began with `current_A`.
  float NextCurrent_A(float current_A, float voltage_V) const noexcept {
    return decay_ * current_A + (1 - decay_) * voltage_V / resistance_ohm_;
  }

  // (1.3): the voltage that brings the current from one value to the other within a step.
  float VoltageFor(float from_A, float to_A) const noexcept {
    return resistance_ohm_ * (to_A - decay_ * from_A) / (1 - decay_);
  }

  // (1.4): mean current of that step.
  float Mean(float from_A, float to_A) const noexcept {
    return VoltageFor(from_A, to_A) / resistance_ohm_ - (to_A - from_A) / step_in_tau_;
  }

  // (1.5): current at the end of a step whose mean current and voltage were measured.
  float EndOf(float mean_A, float voltage_V) const noexcept {
    const float final_A = voltage_V / resistance_ohm_;
    return final_A + (mean_A - final_A) * step_in_tau_ * decay_ / (1 - decay_);
  }

  float resistance_ohm() const noexcept { return resistance_ohm_; }
  float inductance_H() const noexcept { return inductance_H_; }

 private:
  float resistance_ohm_;
  float inductance_H_;
  float step_in_tau_;  // R h / L
  float decay_ = 0;
};

struct CurrentRequest {
  float target_A = 0;
  float slew_A = 0;          // largest change of the reference in a step
  float approach = 1;        // share of the way to the target per step, 0 < approach <= 1
  float voltage_max_V = 0;   // of the mean over the next step
  float against = 1;         // share of it that may oppose the current and thus feed the supply, 0 to 1
  float measured_A = 0;      // mean over the step before
  bool is_measured = false;  // false: no measurement, only the model acts
};

class CurrentControl {
 public:
  // Mean voltage for the next step, |V| <= voltage_max_V.
  float Step(const CoilModel& model, const CurrentRequest& request) noexcept;

  // When the bridge brakes or sleeps: clears reference and integral.
  void Reset() noexcept { *this = CurrentControl{}; }

  float reference_A() const noexcept { return reference_A_; }  // at the end of the step that begins now
  float expected_A() const noexcept { return expected_A_; }    // mean over that step: what will be measured
  float integral_V() const noexcept { return integral_V_; }
  bool is_held_back() const noexcept { return is_held_back_; }  // by voltage, in the last step

 private:
  float reference_A_ = 0;
  float expected_A_ = 0;
  float integral_V_ = 0;
  bool is_held_back_ = false;
};

}  // namespace omni::firmware
