// The last limiter: the sum of all that is rendered, before it becomes currents. Whatever the parts did, the force is
// finite, no larger than the device may make it and grows no faster than the hand is used to; it may fall, or end, at
// once. docs/theory/haptics.md (10.4), (10.5)
#pragma once

#include <type_traits>

#include "service/base/actuation_types.h"

namespace omni::loop {

struct ForceLimiterConfig {
  double rise_N_s = 850;  // the force grows no faster; less for a base that is not well known, MakeTickConfig
};

struct ForceLimiterState {
  base::Vec3 last_N;
};
static_assert(std::is_trivially_copyable_v<ForceLimiterState>);

// Takes up in `limit` what one tick may do: `force_trust` in [0, 1], 0 in doubt, is how far the pose is trusted, and
// the force may grow for `growth_s`, at most one period. Actuation keeps to it as well.
void NarrowLimit(const ForceLimiterConfig& config, double force_trust, double growth_s,
                 base::ForceLimit& limit) noexcept;

// The nearest to `wanted_N` that may follow the force of the tick before. Zero is followed at once; what is no number
// counts as zero.
base::Vec3 LimitForce(const base::ForceLimit& limit, const base::Vec3& wanted_N, ForceLimiterState& state) noexcept;

}  // namespace omni::loop
