#include "service/sim/coils/coil_bank.h"

#include <cmath>

namespace omni::sim {

CoilBank::CoilBank(const base::DeviceGeometry& device, const ThermalConfig& thermal)
    : thermal_(thermal), body_C_(thermal.air_C) {
  for (std::size_t k = 0; k < coils_.size(); ++k) {
    coils_[k].resistance_20C_ohm = device.coils[k].resistance_20C_ohm;
    coils_[k].inductance_H = device.coils[k].inductance_H;
  }
  copper_C_.fill(thermal.air_C);
}

void CoilBank::Scale(std::size_t k, double resistance, double inductance) noexcept {
  coils_[k].resistance_scale = resistance;
  coils_[k].inductance_scale = inductance;
}

double CoilBank::Resistance(std::size_t k) const noexcept {
  return coils_[k].resistance_scale * coils_[k].resistance_20C_ohm *
         (1 + thermal_.resistance_per_K * (copper_C_[k] - 20));
}

double CoilBank::Inductance(std::size_t k) const noexcept {
  return coils_[k].inductance_scale * coils_[k].inductance_H;
}

double CoilBank::Step(std::size_t k, double voltage_V, double series_ohm, double dt_s) noexcept {
  const double resistance = Resistance(k) + series_ohm;
  const double final_A = voltage_V / resistance;
  const double decay = std::exp(-resistance * dt_s / Inductance(k));
  const double away_A = current_A_[k] - final_A;
  current_A_[k] = final_A + away_A * decay;
  return final_A + away_A * (1 - decay) * Inductance(k) / (resistance * dt_s);
}

// With V = -sign(I) against_V the current crosses zero at t0 = ln(1 + |I| R / against_V) L / R; there the diodes block.
double CoilBank::Coast(std::size_t k, double against_V, double dt_s) noexcept {
  const double start_A = current_A_[k];
  if (start_A == 0) return 0;
  const double resistance = Resistance(k);
  const double zero_s = std::log1p(std::abs(start_A) * resistance / against_V) * Inductance(k) / resistance;
  const double runs_s = std::fmin(zero_s, dt_s);
  const double mean_A = Step(k, start_A > 0 ? -against_V : against_V, 0, runs_s);
  if (zero_s <= dt_s) current_A_[k] = 0;
  return mean_A * runs_s / dt_s;
}

void CoilBank::StepHeat(double dt_s, const CoilArray& extra_W) noexcept {
  double into_body_W = -thermal_.body_to_air_W_K * (body_C_ - thermal_.air_C);
  for (std::size_t k = 0; k < copper_C_.size(); ++k) {
    const double flow_W = thermal_.copper_to_body_W_K * (copper_C_[k] - body_C_);
    const double heat_W = current_A_[k] * current_A_[k] * Resistance(k) + extra_W[k];
    copper_C_[k] += (heat_W - flow_W) * dt_s / thermal_.copper_J_K;
    into_body_W += flow_W;
  }
  body_C_ += into_body_W * dt_s / thermal_.body_J_K;
}

}  // namespace omni::sim
