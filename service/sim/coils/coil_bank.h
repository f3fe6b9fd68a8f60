// The coils as circuits and as heaters. The plant's bridges drive them.
#pragma once

#include <array>
#include <cstddef>

#include "service/base/device_geometry.h"
#include "service/base/truth_parameters.h"
#include "service/sim/fields/truth_model.h"

namespace omni::sim {

// Each coil's copper, and the body that all three share:
//   Cc dTc = I^2 R(Tc) dt - Gcb (Tc - Tb) dt,  Cb dTb = sum Gcb (Tc - Tb) dt - Gba (Tb - Ta) dt
// fitted to the paper's temperatures of one coil (39 C at 65 s after 15 A for 25 s, 47 C after 15 min at 5 A) with the
// copper's heat capacity from its mass.
using ThermalConfig = base::ThermalParameters;

class CoilBank {
 public:
  CoilBank(const base::DeviceGeometry& device, const ThermalConfig& thermal);

  // Of a coil as wound: 1. A shorted or a corroded one is scaled.
  void Scale(std::size_t k, double resistance, double inductance) noexcept;

  // R(Tc) = R20 (1 + alpha (Tc - 20)), ohm.
  double Resistance(std::size_t k) const noexcept;

  // L dI/dt = V - (R + series) I, exact over a step of constant V. The mean current of the step, A.
  double Step(std::size_t k, double voltage_V, double series_ohm, double dt_s) noexcept;

  // The bridge sleeps: the current runs against `against_V` > 0 (supply and two diodes) until it is gone. The mean
  // current of the step, A.
  double Coast(std::size_t k, double against_V, double dt_s) noexcept;

  // An ideal current source. For thermal simulations alone.
  void SetCurrents(const CoilArray& current_A) noexcept { current_A_ = current_A; }

  // The wire is cut.
  void Break(std::size_t k) noexcept { current_A_[k] = 0; }

  // `extra_W`: put into each coil's copper by something else.
  void StepHeat(double dt_s, const CoilArray& extra_W = {}) noexcept;

  const CoilArray& current_A() const noexcept { return current_A_; }
  const CoilArray& temperature_C() const noexcept { return copper_C_; }
  double body_C() const noexcept { return body_C_; }  // what a thermometer on the base would show

 private:
  struct Coil {
    double resistance_20C_ohm = 0;
    double inductance_H = 0;
    double resistance_scale = 1, inductance_scale = 1;
  };
  double Inductance(std::size_t k) const noexcept;

  std::array<Coil, base::kCoilCount> coils_;
  ThermalConfig thermal_;
  CoilArray current_A_{};
  CoilArray copper_C_{};
  double body_C_;
};

}  // namespace omni::sim
