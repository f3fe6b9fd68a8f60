// The three bridges: asleep, waking, controlling currents, ramping to zero, braking. Brake before sleep, so that a
// coil's energy ends in its copper and not in the supply. docs/theory/firmware.md (6.1) to (6.4), (2.6)
#pragma once

#include "firmware/core/current_control.h"
#include "firmware/core/safety/coil_heat.h"
#include "firmware/core/safety/fault_rules.h"

namespace omni::firmware {

class Drive {
 public:
  enum class Phase : std::uint8_t { kAsleep, kWake, kControl, kTest, kRamp, kBrake };

  // At zero current first; set-points take effect after kWake_steps.
  void Wake() noexcept;
  // Ends in kAsleep. A brake overrides a ramp, never the reverse.
  void Stop(Reaction reaction) noexcept;
  // Precondition: the coils have braked to zero.
  void Sleep() noexcept { Enter(Phase::kAsleep); }
  // Resets everything, with the bridges braking: after a non-finite number.
  void Panic() noexcept;

  struct Demand {
    float set_point_A[wire::kCoils] = {};
    float measured_A[wire::kCoils] = {};
    std::uint8_t measured_mask = 0;
    float supply_V = 0;
  };
  void Step(const Settings& settings, const CoilHeat& heat, const Demand& demand, Outputs& outputs) noexcept;

  // Instead of Step: the self-test's voltages.
  void StepTest(const float (&voltage_V)[wire::kCoils], bool awake, float supply_V, Outputs& outputs) noexcept;

  Phase phase() const noexcept { return phase_; }
  bool is_asleep() const noexcept { return phase_ == Phase::kAsleep; }
  int asleep_steps() const noexcept { return is_asleep() ? in_phase_ : 0; }
  // True: the previous step followed a reference, so its mean current should have been expected_A.
  bool follows() const noexcept { return phase_ == Phase::kControl || phase_ == Phase::kRamp; }
  float expected_A(int coil) const noexcept { return controls_[coil].expected_A(); }
  // Sign of the previous step's voltage.
  float direction(int coil) const noexcept { return duty_[coil] < 0 ? -1.0F : 1.0F; }
  bool is_finite() const noexcept;

 private:
  void Enter(Phase phase) noexcept;
  void Control(const Settings& settings, const CoilHeat& heat, const Demand& demand) noexcept;
  void SetDuty(int coil, float voltage_V, float supply_V) noexcept;
  void Write(Outputs& outputs) const noexcept;

  Phase phase_ = Phase::kAsleep;
  int in_phase_ = 0;  // steps
  CurrentControl controls_[wire::kCoils];
  float ramp_A_[wire::kCoils] = {};  // per step
  std::int16_t duty_[wire::kCoils] = {};
};

}  // namespace omni::firmware
