// The one rule for "can the device push this hard, there": shared by haptics (scales what it asks for) and actuation
// (scales what it sends). Vector scaling keeps the direction (docs/theory/actuation.md).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "service/base/actuation_types.h"

namespace omni::base {

// Largest s in [0, 1] such that s * force is feasible under `limit`; 0 if the limit is invalid or anything is not
// finite.
inline double FeasibleScale(const ForceLimit& limit, const Vec3& force_N) noexcept {
  const double norm_N = std::sqrt(force_N.x * force_N.x + force_N.y * force_N.y + force_N.z * force_N.z);
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

}  // namespace omni::base
