#include "service/actuation/heat.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"

namespace omni::actuation {
namespace {

constexpr double kHorizon_s = 5;    // h of docs/theory/thermal.md (4)
constexpr double kHottest_C = 250;  // copper is insulated for less: beyond it the model only has to stay finite
constexpr double kColdest_C = -60;  // of a place where a base is used
constexpr double kHeatStep_s =
    0.25;  // stable for any pair of nodes this model is meant for; a longer gap counts as this

// Everything as warm as the warmest coil reports: after a restart the body's temperature is unknown.
void Start(const HeatConfig& config, const base::HallScan& scan, HeatState& state) noexcept {
  double warmest_C = config.nodes.air_C;
  for (const double measured_C : scan.coil_temperature_C) {
    if (measured_C > warmest_C) warmest_C = std::min(measured_C, config.temperature_max_C);
  }
  state = HeatState{.started = true, .t_ns = scan.t_ns, .body_C = warmest_C};
  state.copper_C.fill(warmest_C);
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    state.current_max_A[k] = CurrentCeiling_A(config, k, warmest_C, warmest_C);
  }
}

double Heating_A(double measured_A, double commanded_A) noexcept {
  const double commanded = std::isfinite(commanded_A) ? std::abs(commanded_A) : 0;
  return std::isfinite(measured_A) ? std::max(std::abs(measured_A), commanded) : commanded;
}

}  // namespace

HeatConfig MakeHeatConfig(const base::DeviceGeometry& device) {
  HeatConfig config;
  config.nodes = device.heat;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) config.resistance_20C_ohm[k] = device.coils[k].resistance_20C_ohm;
  config.current_max_A = device.current_max_A;
  config.supply_V = device.supply_V;
  config.decay = std::exp(-kHorizon_s * device.heat.copper_to_body_W_K / device.heat.copper_J_K);
  config.temperature_max_C = device.temperature_max_C;
  config.temperature_aim_C = device.temperature_max_C - 0.25 * (device.temperature_max_C - device.temperature_derate_C);
  return config;
}

double CopperResistance_ohm(const HeatConfig& config, std::size_t k, double copper_C) noexcept {
  const bool possible = copper_C >= kColdest_C && copper_C <= kHottest_C;
  return config.resistance_20C_ohm[k] * (1 + kCopperPerKelvin * ((possible ? copper_C : kHottest_C) - 20));
}

// Cc dTc/dt = I^2 R(Tc) - Gcb (Tc - Tb),   Cb dTb/dt = sum Gcb (Tc - Tb) - Gba (Tb - Ta): explicit Euler.
// docs/theory/thermal.md (1), (2)
void AdvanceHeat(const HeatConfig& config, const std::array<double, base::kCoilCount>& current_A, double dt_s,
                 HeatState& state) noexcept {
  const base::HeatGeometry& node = config.nodes;
  double into_body_W = -node.body_to_air_W_K * (state.body_C - node.air_C);
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    double& copper_C = state.copper_C[k];
    const double flow_W = node.copper_to_body_W_K * (copper_C - state.body_C);
    const double heat_W = current_A[k] * current_A[k] * CopperResistance_ohm(config, k, copper_C);
    copper_C += (heat_W - flow_W) * dt_s / node.copper_J_K;
    into_body_W += flow_W;
  }
  state.body_C += into_body_W * dt_s / node.body_J_K;
}

// With P = Gcb [(Tm - Tb) - d (Tc - Tb)] / (1 - d), d = exp(-h Gcb / Cc), the copper obeys
// dTc/dt <= Gcb / (Cc (1 - d)) (Tm - Tc): it approaches the aim Tm from below and never passes it, whatever Tb does.
// docs/theory/thermal.md (4) - (6)
double CurrentCeiling_A(const HeatConfig& config, std::size_t k, double copper_C, double body_C) noexcept {
  const base::HeatGeometry& node = config.nodes;
  const double aim_C = config.temperature_aim_C;
  if (!(copper_C < config.temperature_max_C && body_C < config.temperature_max_C)) return 0;
  const double d = config.decay;
  const double excess_C = std::min(copper_C, aim_C) - body_C;
  const double allowed_W = node.copper_to_body_W_K * ((aim_C - body_C) - d * excess_C) / (1 - d);
  if (!(allowed_W > 0)) return 0;
  const double heat_A = std::sqrt(allowed_W / CopperResistance_ohm(config, k, aim_C));
  const double supply_A = config.supply_V / CopperResistance_ohm(config, k, copper_C);
  const double span = config.temperature_max_C - aim_C;  // beyond the aim the model was wrong: down to zero
  const double left = span > 0 ? std::clamp((config.temperature_max_C - copper_C) / span, 0.0, 1.0) : 1.0;
  const double ceiling_A = left * std::min({config.current_max_A, heat_A, supply_A});
  return ceiling_A > 0 ? ceiling_A : 0;
}

void UpdateHeat(const HeatConfig& config, const base::HallScan& scan,
                const std::array<double, base::kCoilCount>& commanded_A, HeatState& state) noexcept {
  if (!state.started) {
    Start(config, scan, state);
    return;
  }
  const double elapsed_s = base::Elapsed_s(scan.t_ns, state.t_ns);
  const double dt_s = std::clamp(elapsed_s, 0.0, kHeatStep_s);
  state.t_ns = scan.t_ns;
  std::array<double, base::kCoilCount> heating_A{};
  for (std::size_t k = 0; k < heating_A.size(); ++k) {
    heating_A[k] = std::min(Heating_A(scan.coil_current_A[k], commanded_A[k]), 2 * config.current_max_A);
  }
  AdvanceHeat(config, heating_A, dt_s, state);
  state.body_C = std::min(state.body_C, kHottest_C);
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const double measured_C = std::min(scan.coil_temperature_C[k], kHottest_C);
    double& copper_C = state.copper_C[k];
    if (measured_C > copper_C) copper_C += (measured_C - copper_C) * std::min(1.0, dt_s / config.follow_s);
    copper_C = std::min(copper_C, kHottest_C);
    const double wanted_A = std::isfinite(measured_C) ? CurrentCeiling_A(config, k, copper_C, state.body_C) : 0.0;
    const double held_A = state.current_max_A[k];
    state.current_max_A[k] = std::clamp(wanted_A, held_A - config.fall_A_s * dt_s, held_A + config.rise_A_s * dt_s);
  }
}

}  // namespace omni::actuation
