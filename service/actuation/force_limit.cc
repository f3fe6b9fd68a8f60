#include <algorithm>
#include <cmath>

#include "service/actuation/actuation.h"
#include "service/actuation/inverse.h"

namespace omni::actuation {
namespace {

constexpr double kGravity_m_s2 = 9.80665;

using Currents = std::array<double, base::kCoilCount>;

base::Vec3 Times(const std::array<double, 9>& M, const base::Vec3& v) noexcept {
  return {M[0] * v.x + M[1] * v.y + M[2] * v.z, M[3] * v.x + M[4] * v.y + M[5] * v.z,
          M[6] * v.x + M[7] * v.y + M[8] * v.z};
}

// Currents that lift the tool's weight, as far as every coil stays within its share: scaled, so continuous in the pose.
Currents CarryWeight(const Config& config, const base::ForceLimit& limit) noexcept {
  const base::Vec3 lift = Times(limit.ampere_per_newton, {0, 0, config.weight_N});
  const Currents whole_A{lift.x, lift.y, lift.z};
  double share = 1;
  for (std::size_t k = 0; k < whole_A.size(); ++k) {
    const double allowed_A = std::min(config.weight_current_max_A, 0.5 * limit.current_max_A[k]);
    if (!(std::abs(whole_A[k]) * share <= allowed_A)) share = std::max(0.0, allowed_A) / std::abs(whole_A[k]);
  }
  Currents carried_A{};
  for (std::size_t k = 0; k < whole_A.size(); ++k) carried_A[k] = share * whole_A[k];
  return carried_A;
}

base::ForceLimit LimitWith(const Config& config, const base::ToolState& tool, const Currents& current_max_A) noexcept {
  base::ForceLimit limit;
  if (tool.status != base::TrackingStatus::kTracking || !(tool.gap_m < config.gap_max_m)) return limit;
  const ForceAtPose force = EvaluateForceMap(config.map, tool.position_base_m, tool.axis_base);
  if (!force.valid) return limit;
  const DampedInverse inverse = InvertForceMap(force.newton_per_ampere, config.singular_ratio);
  if (!inverse.valid) return limit;
  limit.near_singular = inverse.damped;
  limit.keeps_direction = config.infeasible == Infeasible::kKeepDirection;
  limit.ampere_per_newton = inverse.ampere_per_newton;
  limit.conditioning = inverse.conditioning;
  limit.newton_per_ampere = force.newton_per_ampere;
  limit.newton_metre_per_ampere = force.newton_metre_per_ampere;
  limit.snapping_N = force.snapping_N;
  limit.snapping_Nm = force.snapping_Nm;
  if (config.compensate_snapping) {
    const base::Vec3 held = Times(inverse.ampere_per_newton, force.snapping_N);
    limit.bias_A = {-held.x, -held.y, -held.z};
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    limit.current_max_A[k] = current_max_A[k] >= 0 ? std::min(current_max_A[k], config.current_max_A) : 0.0;
  }
  if (config.compensate_weight) limit.weight_A = CarryWeight(config, limit);
  const double fade = config.gap_fade_m > 0 ? (config.gap_max_m - tool.gap_m) / config.gap_fade_m : 1.0;
  limit.force_max_N = config.force_max_N * std::clamp(fade, 0.0, 1.0);
  limit.valid = true;
  return limit;
}

Config WithLimits(const base::DeviceGeometry& device, const ForceMap& map) {
  Config config;
  config.map = map;
  config.heat = MakeHeatConfig(device);
  config.current_max_A = device.current_max_A;
  config.current_slew_A_s = device.current_slew_A_s;
  config.force_max_N = device.force_max_N;
  config.temperature_max_C = device.temperature_max_C;
  config.resistance_20C_ohm = config.heat.resistance_20C_ohm;
  config.weight_N = device.magnet.mass_kg * kGravity_m_s2;
  return config;
}

}  // namespace

Config MakeConfig(const base::DeviceGeometry& device) { return WithLimits(device, MakeForceMap(device)); }

Config MakeConfig(const base::DeviceGeometry& device, const base::Calibration& calibration) {
  return WithLimits(device, MakeForceMap(device, calibration));
}

void UpdateHeat(const Config& config, const base::HallScan& scan, State& state) noexcept {
  UpdateHeat(config.heat, scan, state.last_current_A, state.heat);
}

base::ForceLimit ComputeDeratedLimit(const Config& config, const base::ToolState& tool,
                                     const HeatState& heat) noexcept {
  return LimitWith(config, tool, heat.current_max_A);
}

base::ForceLimit ComputeForceLimit(const Config& config, const base::ToolState& tool,
                                   const std::array<double, 3>& coil_temperature_C) noexcept {
  Currents current_max_A{};
  for (std::size_t k = 0; k < current_max_A.size(); ++k) {
    current_max_A[k] = CurrentCeiling_A(config.heat, k, coil_temperature_C[k], coil_temperature_C[k]);
  }
  return LimitWith(config, tool, current_max_A);
}

double ForceMax_N(const Config& config, const base::ToolState& tool, const base::Vec3& direction,
                  const std::array<double, 3>& coil_temperature_C) noexcept {
  return base::ForceMax_N(ComputeForceLimit(config, tool, coil_temperature_C), direction);
}

void FadeWeight(double gain, base::ForceLimit& limit) noexcept {
  const double share = gain >= 0 ? std::min(gain, 1.0) : 0.0;
  for (double& current_A : limit.weight_A) current_A *= share;
}

base::Vec3 ForceFromCurrents(const ForceMap& map, const base::ToolState& tool,
                             const std::array<double, base::kCoilCount>& coil_current_A) noexcept {
  const ForceAtPose force = EvaluateForceMap(map, tool.position_base_m, tool.axis_base);
  if (!force.valid) return {};
  const base::Vec3 coils = Times(force.newton_per_ampere, {coil_current_A[0], coil_current_A[1], coil_current_A[2]});
  return {coils.x + force.snapping_N.x, coils.y + force.snapping_N.y, coils.z + force.snapping_N.z};
}

}  // namespace omni::actuation
