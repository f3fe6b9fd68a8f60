#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "service/actuation/actuation.h"

namespace omni::actuation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// Force to currents: the inverse of the force map, damped where one direction cannot be pushed.
struct DampedInverse {
  bool valid = false;                         // false: X is zero or not finite, all zero
  bool damped = false;                        // conditioning < singular_ratio: one direction fades out
  double conditioning = 0;                    // smallest over largest singular value
  std::array<double, 9> ampere_per_newton{};  // row-major 3x3
};

// docs/theory/actuation.md (3.1)
// X^T (X X^T + lambda^2 v v^T)^-1 with v the direction the coils push worst and, for s = sigma_min / sigma_max below
// `singular_ratio` = s0: lambda = sigma_max s0 (1 - (s/s0)^2) / 2   [Maciejewski & Klein 1988, numerical filtering].
// At s = 0 the gain along v is 0; at s = s0 the inverse is exact; in between it is continuous.
DampedInverse InvertForceMap(const std::array<double, 9>& newton_per_ampere, double singular_ratio) noexcept {
  DampedInverse result;
  const Matrix3d X = Eigen::Map<const RowMajor3d>(newton_per_ampere.data());
  if (!X.allFinite()) return result;
  Matrix3d XXt = X * X.transpose();
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(XXt, Eigen::EigenvaluesOnly);  // closed form: no iteration; eigenvalues ascend
  const double largest = eigen.eigenvalues()[2];
  if (!(largest > 0)) return result;
  const double smallest = std::max(0.0, eigen.eigenvalues()[0]);
  result.conditioning = std::sqrt(smallest / largest);
  const double threshold = singular_ratio * singular_ratio * largest;
  result.damped = smallest < threshold;
  Matrix3d inverse;
  if (result.damped) {
    eigen.computeDirect(XXt);
    const Vector3d v = eigen.eigenvectors().col(0);
    const double shortfall = 1 - smallest / threshold;
    XXt += (0.25 * threshold * shortfall * shortfall) * v * v.transpose();
    inverse = X.transpose() * XXt.inverse();
  } else {
    inverse = X.inverse();
  }
  result.valid = inverse.allFinite();
  if (result.valid) Eigen::Map<RowMajor3d>(result.ampere_per_newton.data()) = inverse;
  return result;
}

using Currents = std::array<double, base::kCoilCount>;

base::ForceLimit LimitWith(const Config& config, const base::ToolState& tool, const Currents& current_max_A,
                           const std::array<double, base::kCoilCount>& copper_C) noexcept {
  base::ForceLimit limit;
  if (tool.status != base::TrackingStatus::kTracking || !(tool.gap_m < config.gap_max_m)) return limit;
  const ForceAtPose force = EvaluateForceMap(config.map, tool.position_base_m, tool.axis_base, tool.moment_scale);
  if (!force.valid) return limit;
  const DampedInverse inverse = InvertForceMap(force.newton_per_ampere, config.singular_ratio);
  if (!inverse.valid) return limit;
  limit.near_singular = inverse.damped;
  limit.ampere_per_newton = inverse.ampere_per_newton;
  limit.conditioning = inverse.conditioning;
  limit.newton_per_ampere = force.newton_per_ampere;
  limit.newton_metre_per_ampere = force.newton_metre_per_ampere;
  limit.snapping_N = force.snapping_N;
  limit.snapping_Nm = force.snapping_Nm;
  if (config.compensate_snapping) {
    const base::Vec3 held = base::Multiply(inverse.ampere_per_newton, force.snapping_N);
    limit.bias_A = {-held.x, -held.y, -held.z};
    limit.bias_fade_N = config.bias_fade_N;
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    limit.current_max_A[k] = current_max_A[k] >= 0 ? std::min(current_max_A[k], config.current_max_A) : 0.0;
    limit.resistance_ohm[k] = CopperResistance_ohm(config.heat, k, copper_C[k]);
  }
  limit.power_max_W = config.power_max_W;
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
  return LimitWith(config, tool, heat.current_max_A, heat.copper_C);
}

base::ForceLimit ComputeForceLimit(const Config& config, const base::ToolState& tool,
                                   const std::array<double, 3>& coil_temperature_C) noexcept {
  Currents current_max_A{};
  for (std::size_t k = 0; k < current_max_A.size(); ++k) {
    current_max_A[k] = CurrentCeiling_A(config.heat, k, coil_temperature_C[k], coil_temperature_C[k]);
  }
  return LimitWith(config, tool, current_max_A, coil_temperature_C);
}

double ForceMax_N(const Config& config, const base::ToolState& tool, const base::Vec3& direction,
                  const std::array<double, 3>& coil_temperature_C) noexcept {
  return base::ForceMax_N(ComputeForceLimit(config, tool, coil_temperature_C), direction);
}

base::Vec3 ForceFromCurrents(const ForceMap& map, const base::ToolState& tool,
                             const std::array<double, base::kCoilCount>& coil_current_A) noexcept {
  const ForceAtPose force = EvaluateForceMap(map, tool.position_base_m, tool.axis_base, tool.moment_scale);
  if (!force.valid) return {};
  const base::Vec3 current_A{coil_current_A[0], coil_current_A[1], coil_current_A[2]};
  return base::Multiply(force.newton_per_ampere, current_A) + force.snapping_N;
}

}  // namespace omni::actuation
