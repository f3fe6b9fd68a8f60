// The last limiter, for the sum of all rendered forces before it becomes currents. Whatever the parts did, the force is
// finite, within the device's limit, and rises no faster than its rate limit; it may fall, or end, at once.
// docs/theory/haptics.md (10.4), (10.5)
#pragma once

#include <array>
#include <type_traits>

#include "service/base/force_limit.h"

namespace omni::loop {

inline constexpr double kPoseError_step_m = 1e-3;

struct ForceLimiterConfig {
  double rise_N_s = 850;  // largest rise of the force; less for a base that is not well known, MakeTickConfig
  // Trust in a pose whose error may be 0, kPoseError_step_m, ...; beyond the last: none. MakeTickConfig
  std::array<double, 13> pose_trust{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
};

struct ForceLimiterState {
  base::Vec3 last_N;
};
static_assert(std::is_trivially_copyable_v<ForceLimiterState>);

// Linear between the entries of the table; 0 for NaN.
double PoseTrust(const ForceLimiterConfig& config, double error_m) noexcept;

// Narrows `limit` to what one tick may do: `force_trust` in [0, 1], 0 in doubt, is the trust in the pose, and the force
// may rise for `growth_s`, at most one period. Actuation obeys it as well.
void NarrowLimit(const ForceLimiterConfig& config, double force_trust, double growth_s,
                 base::ForceLimit& limit) noexcept;

// The force nearest to `wanted_N` that may follow the one of the tick before. Zero is reached at once; a force that is
// not finite counts as zero.
base::Vec3 LimitForce(const base::ForceLimit& limit, const base::Vec3& wanted_N, ForceLimiterState& state) noexcept;

}  // namespace omni::loop
