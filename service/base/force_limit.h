// The one rule for "can the device push this hard, there": shared by haptics (scales its request) and actuation (scales
// its output). Vector scaling keeps the direction (docs/theory/actuation.md).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "service/base/actuation_types.h"

namespace omni::base {

// Largest s in [0, 1] such that s * force is feasible under `limit`; 0 if the limit is invalid or anything is not
// finite. Where the limit does not keep directions only force_max_N scales: actuation finds the nearest force.
inline double FeasibleScale(const ForceLimit& limit, const Vec3& force_N) noexcept {
  const double norm_N = Norm(force_N);
  if (!limit.valid || !(norm_N <= 1e6)) return 0;
  if (norm_N == 0) return 1;
  double scale = std::min(1.0, limit.force_max_N / norm_N);
  for (std::size_t k = 0; k < kCoilCount; ++k) {
    const double* row = &limit.ampere_per_newton[3 * k];
    const double current_A = row[0] * force_N.x + row[1] * force_N.y + row[2] * force_N.z;
    const double bias_A = limit.bias_A[k];
    // |bias + s I| <= max: the headroom depends on the sign of I.
    const double headroom_A = limit.current_max_A[k] - (current_A > 0 ? bias_A : -bias_A);
    if (!(headroom_A > 0)) return 0;
    if (std::abs(current_A) * scale > headroom_A) scale = headroom_A / std::abs(current_A);
    if (!(scale >= 0)) return 0;
  }
  return scale;
}

// The largest force in direction `direction` (any length) that keeps its direction; 0 in doubt.
inline double ForceMax_N(const ForceLimit& limit, const Vec3& direction) noexcept {
  const double norm = Norm(direction);
  if (!(norm > 0 && norm <= 1e6)) return 0;
  const double gain = limit.force_max_N / norm;
  return FeasibleScale(limit, gain * direction) * limit.force_max_N;
}

// Torque on the tool while `current_A` flow, about the magnet's centre. Zero where the pose is unknown.
inline Vec3 TorqueOf_Nm(const ForceLimit& limit, const std::array<double, kCoilCount>& current_A) noexcept {
  if (!limit.valid) return {};
  const double* Y = limit.newton_metre_per_ampere.data();
  const auto row = [&](int i) { return Y[i] * current_A[0] + Y[i + 1] * current_A[1] + Y[i + 2] * current_A[2]; };
  return {row(0) + limit.snapping_Nm.x, row(3) + limit.snapping_Nm.y, row(6) + limit.snapping_Nm.z};
}

}  // namespace omni::base
