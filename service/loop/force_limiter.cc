#include "service/loop/force_limiter.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/base/force_limit.h"
#include "service/base/limits.h"

namespace omni::loop {

using Eigen::Vector3d;

double PoseTrust(const ForceLimiterConfig& config, double error_m) noexcept {
  const double place = error_m / kPoseError_step_m;
  const std::size_t last = config.pose_trust.size() - 1;
  if (!(place >= 0 && place <= static_cast<double>(last))) return 0;
  const std::size_t i = std::min(static_cast<std::size_t>(place), last - 1);
  const double share = place - static_cast<double>(i);
  return (1 - share) * config.pose_trust[i] + share * config.pose_trust[i + 1];
}

// A longer tick counts as one period: the rise that lost scans would have allowed is not made up for.
void NarrowLimit(const ForceLimiterConfig& config, double force_trust, double growth_s,
                 base::ForceLimit& limit) noexcept {
  const double trust = force_trust >= 0 ? std::min(force_trust, 1.0) : 0.0;
  const double step_s = growth_s >= 0 ? std::min(growth_s, base::kTickPeriod_s) : 0.0;
  limit.force_max_N *= trust;
  limit.force_rise_N = trust * config.rise_N_s * step_s;
}

// F = P + min(1, rise / |W - P|) (W - P), P the point of the segment from zero to the last force that is nearest to W:
// what lies on that segment is reached by falling alone. The pose may have moved to where less force is possible, so
// the device's limit comes last.
base::Vec3 LimitForce(const base::ForceLimit& limit, const base::Vec3& wanted_N, ForceLimiterState& state) noexcept {
  const Vector3d wanted = base::ToEigen(wanted_N), last = base::ToEigen(state.last_N);
  const double along = last.dot(wanted);
  const Vector3d nearest = along > 0 ? Vector3d(std::min(1.0, along / last.squaredNorm()) * last) : Vector3d::Zero();
  const Vector3d growth = wanted - nearest;
  const double size_N = growth.norm();
  const bool grows_slowly = size_N <= limit.force_rise_N;
  const Vector3d limited = grows_slowly ? wanted : Vector3d(nearest + (limit.force_rise_N / size_N) * growth);
  const double scale = base::FeasibleScale(limit, base::FromEigen(limited));  // 0 if it is not finite
  state.last_N = scale > 0 ? base::FromEigen(Vector3d(scale * limited)) : base::Vec3{};
  return state.last_N;
}

}  // namespace omni::loop
