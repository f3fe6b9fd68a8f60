// The last limiter: the sum of all that is rendered, before it becomes currents. Whatever the parts did, the force is
// finite, no larger than the device may make it and grows no faster than the hand is used to; it may fall, or end, at
// once. docs/theory/haptics.md (10.4), (10.5)
#pragma once

#include <array>
#include <type_traits>

#include "service/base/actuation_types.h"

namespace omni::loop {

inline constexpr double kPoseError_step_m = 1e-3;

struct ForceLimiterConfig {
  double rise_N_s = 850;  // the force grows no faster; less for a base that is not well known, MakeTickConfig
  // How far a pose is trusted whose error may be 0, kPoseError_step_m, ...; beyond the last: not at all. MakeTickConfig
  std::array<double, 13> pose_trust{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
};

struct ForceLimiterState {
  base::Vec3 last_N;
};
static_assert(std::is_trivially_copyable_v<ForceLimiterState>);

// Linear between the entries of the table; 0 for what is no number.
double PoseTrust(const ForceLimiterConfig& config, double error_m) noexcept;

// Takes up in `limit` what one tick may do: `force_trust` in [0, 1], 0 in doubt, is how far the pose is trusted, and
// the force may grow for `growth_s`, at most one period. Actuation keeps to it as well.
void NarrowLimit(const ForceLimiterConfig& config, double force_trust, double growth_s,
                 base::ForceLimit& limit) noexcept;

// The nearest to `wanted_N` that may follow the force of the tick before. Zero is followed at once; what is no number
// counts as zero.
base::Vec3 LimitForce(const base::ForceLimit& limit, const base::Vec3& wanted_N, ForceLimiterState& state) noexcept;

}  // namespace omni::loop
