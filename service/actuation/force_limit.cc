#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "service/actuation/actuation.h"
#include "service/base/eigen.h"

namespace omni::actuation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// X^T (X X^T + lambda^2 v v^T)^-1 with v the direction the coils push worst and, for s = sigma_min / sigma_max below
// `singular_ratio` = s0: lambda = sigma_max s0 (1 - (s/s0)^2) / 2   [Maciejewski & Klein 1988, numerical filtering].
// At s = 0 the gain along v is 0; at s = s0 the inverse is exact; in between it is continuous.
Matrix3d DampedInverse(const Matrix3d& X, double singular_ratio) noexcept {
  Matrix3d XXt = X * X.transpose();
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(XXt);  // closed form: no iteration; eigenvalues ascend
  const double largest = eigen.eigenvalues()[2];
  if (!(largest > 0)) return Matrix3d::Zero();
  const double threshold = singular_ratio * singular_ratio * largest;
  const double shortfall = threshold > 0 ? 1 - std::max(0.0, eigen.eigenvalues()[0]) / threshold : 0.0;
  if (shortfall > 0) {
    const Vector3d v = eigen.eigenvectors().col(0);
    XXt += (0.25 * threshold * shortfall * shortfall) * v * v.transpose();
  }
  return X.transpose() * XXt.inverse();
}

// 1 below the derating temperature, 0 at the maximum and for a temperature that is not a number.
double Derating(const Config& config, double temperature_C) noexcept {
  const double span = config.temperature_max_C - config.temperature_derate_C;
  if (!(span > 0)) return temperature_C < config.temperature_max_C ? 1.0 : 0.0;
  const double left = (config.temperature_max_C - temperature_C) / span;
  if (!(left > 0)) return 0;
  return std::min(1.0, left);
}

}  // namespace

Config MakeConfig(const base::DeviceGeometry& device) {
  Config config;
  config.map = MakeForceMap(device);
  config.current_max_A = device.current_max_A;
  config.current_slew_A_s = device.current_slew_A_s;
  config.force_max_N = device.force_max_N;
  config.temperature_derate_C = device.temperature_derate_C;
  config.temperature_max_C = device.temperature_max_C;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) config.resistance_20C_ohm[k] = device.coils[k].resistance_20C_ohm;
  config.supply_V = device.supply_V;
  return config;
}

base::ForceLimit ComputeForceLimit(const Config& config, const base::ToolState& tool,
                                   const std::array<double, 3>& coil_temperature_C) noexcept {
  base::ForceLimit limit;
  if (tool.status != base::TrackingStatus::kTracking || !(tool.gap_m < config.gap_max_m)) return limit;
  const ForceAtPose force = EvaluateForceMap(config.map, tool.position_base_m, tool.axis_base);
  if (!force.valid) return limit;
  const Matrix3d inverse =
      DampedInverse(Eigen::Map<const RowMajor3>(force.newton_per_ampere.data()), config.singular_ratio);
  if (!inverse.allFinite()) return limit;
  Eigen::Map<RowMajor3>(limit.ampere_per_newton.data()) = inverse;
  if (config.compensate_snapping) {
    Eigen::Map<Vector3d>(limit.bias_A.data()) = -inverse * base::ToEigen(force.snapping_N);
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    limit.current_max_A[k] = config.current_max_A * Derating(config, coil_temperature_C[k]);
  }
  const double fade = config.gap_fade_m > 0 ? (config.gap_max_m - tool.gap_m) / config.gap_fade_m : 1.0;
  limit.force_max_N = config.force_max_N * std::clamp(fade, 0.0, 1.0);
  limit.valid = true;
  return limit;
}

base::Vec3 ForceFromCurrents(const ForceMap& map, const base::ToolState& tool,
                             const std::array<double, base::kCoilCount>& coil_current_A) noexcept {
  const ForceAtPose force = EvaluateForceMap(map, tool.position_base_m, tool.axis_base);
  if (!force.valid) return {};
  const Vector3d F =
      Eigen::Map<const RowMajor3>(force.newton_per_ampere.data()) * Eigen::Map<const Vector3d>(coil_current_A.data()) +
      base::ToEigen(force.snapping_N);
  return base::FromEigen(F);
}

}  // namespace omni::actuation
