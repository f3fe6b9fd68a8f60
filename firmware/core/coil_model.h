// A coil as resistance and inductance over one control step of constant mean voltage. docs/theory/firmware.md (1.1) to
// (1.5)
#pragma once

#include "firmware/core/numbers.h"

namespace omni::firmware {

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
  float Next(float current_A, float voltage_V) const noexcept {
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

}  // namespace omni::firmware
