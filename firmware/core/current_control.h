// One coil's current: a reference that the supply can always follow, the voltage that produces it according to the
// model, and a PI controller for the model's errors. docs/theory/firmware.md (2.1) to (2.5)
#pragma once

#include "firmware/core/coil_model.h"

namespace omni::firmware {

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
