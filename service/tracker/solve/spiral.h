// Directions spread evenly over the sphere.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace omni::tracker {

// Direction n of `count`, 0 <= n < count, on a Fibonacci spiral from +z to -z.
inline Eigen::Vector3d OnSpiral(int n, int count) noexcept {
  const double golden_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  const double z = 1 - (2 * n + 1.0) / count, rho = std::sqrt(1 - z * z);
  return {rho * std::cos(golden_rad * n), rho * std::sin(golden_rad * n), z};
}

}  // namespace omni::tracker
