#include "service/base/force_limit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace omni::base {
namespace {

using Currents = std::array<double, kCoilCount>;

constexpr double kForceMax_N = 1e6;  // a larger request is a mistake, like one that is not a number
constexpr double kRounding = 1e-12;  // relative: a force at its limit is feasible
constexpr int kIterations = 40;      // of a root that is found in about five

// A f
Currents Push(const ForceLimit& limit, const Vec3& force_N) noexcept {
  const Vec3 push = Multiply(limit.ampere_per_newton, force_N);
  return {push.x, push.y, push.z};
}

// Smooth step: 0 at 0, 1 from bias_fade_N on, slope 0 at both ends.   (4.2)
double BiasShare(const ForceLimit& limit, double force_N) noexcept {
  if (!(force_N < limit.bias_fade_N)) return 1;
  const double t = force_N / limit.bias_fade_N;
  return t * t * (3 - 2 * t);
}

Currents Bias(const ForceLimit& limit, double share) noexcept {
  return {share * limit.bias_A[0], share * limit.bias_A[1], share * limit.bias_A[2]};
}

// start + s step is within every limit, but for rounding.
bool Fits(const ForceLimit& limit, const Currents& start_A, const Currents& step_A, double s) noexcept {
  double power_W = 0;
  for (std::size_t k = 0; k < start_A.size(); ++k) {
    const double current_A = start_A[k] + s * step_A[k];
    if (!(std::abs(current_A) <= (1 + kRounding) * limit.current_max_A[k])) return false;
    power_W += limit.resistance_ohm[k] * current_A * current_A;
  }
  return power_W <= (1 + kRounding) * limit.power_max_W;
}

// sum R (start + s step)^2 - P
LimitAlong Heat(const ForceLimit& limit, const Currents& start_A, const Currents& step_A) noexcept {
  LimitAlong heat{.c = -limit.power_max_W};
  for (std::size_t k = 0; k < start_A.size(); ++k) {
    const double start_V = limit.resistance_ohm[k] * start_A[k];
    heat.a += limit.resistance_ohm[k] * step_A[k] * step_A[k];
    heat.b += start_V * step_A[k];
    heat.c += start_V * start_A[k];
  }
  return heat;
}

// |s f + (1 - w) F_snap|^2 - max(F_max, |F_snap|)^2: the core's pull that is left, actuation.md (6.2).
LimitAlong NetForce(const ForceLimit& limit, const Vec3& force_N, double share) noexcept {
  const double pull_N2 = SquaredNorm(limit.snapping_N);
  const double left = 1 - share;
  return {.a = SquaredNorm(force_N),
          .b = left * Dot(force_N, limit.snapping_N),
          .c = left * left * pull_N2 - std::max(limit.force_max_N * limit.force_max_N, pull_N2)};
}

// FeasibleScale up to the size from which the whole bias flows. The share of the bias depends on the scale s, and with
// the share of s the largest scale is t(s): the root of t(s) - s, by false position (Illinois), from the feasible side.
double ScaleOfSmall(const ForceLimit& limit, const Vec3& force_N, const Currents& push_A, double norm_N,
                    double most) noexcept {
  const auto beyond = [&](double s) {
    const double share = BiasShare(limit, s * norm_N);
    return NetForce(limit, force_N, share).ClampToLimit(LargestShare(limit, Bias(limit, share), push_A, most)) - s;
  };
  double low = 0, high = most;
  double at_high = beyond(high);
  if (at_high >= -kRounding * high) return high;
  double at_low = beyond(low);
  if (!(at_low > 0)) return 0;
  for (int i = 0, side = 0; i < kIterations && high - low > kRounding * high; ++i) {
    const double s = (low * at_high - high * at_low) / (at_high - at_low);
    const double at = beyond(s);
    if (at >= 0) {
      low = s;
      at_low = at;
      if (!(at > kRounding * s)) break;
      if (side == 1) at_high *= 0.5;
      side = 1;
    } else {
      high = s;
      at_high = at;
      if (side == -1) at_low *= 0.5;
      side = -1;
    }
  }
  return low;
}

}  // namespace

Currents CurrentsFor_A(const ForceLimit& limit, const Vec3& force_N) noexcept {
  Currents current_A = Push(limit, force_N);
  const Currents held_A = Bias(limit, BiasShare(limit, Norm(force_N)));
  for (std::size_t k = 0; k < current_A.size(); ++k) current_A[k] += held_A[k];
  return current_A;
}

double Power_W(const ForceLimit& limit, const Currents& current_A) noexcept {
  double power_W = 0;
  for (std::size_t k = 0; k < current_A.size(); ++k) power_W += limit.resistance_ohm[k] * current_A[k] * current_A[k];
  return power_W;
}

double LargestShare(const ForceLimit& limit, const Currents& start_A, const Currents& step_A, double most) noexcept {
  if (Fits(limit, start_A, step_A, most)) return most;
  double share = most;
  for (std::size_t k = 0; k < start_A.size(); ++k) {
    if (std::abs(start_A[k] + share * step_A[k]) <= limit.current_max_A[k]) continue;
    const double end = (std::copysign(limit.current_max_A[k], step_A[k]) - start_A[k]) / step_A[k];
    if (!(end >= 0)) return -1;
    share = std::min(share, end);
  }
  share = Heat(limit, start_A, step_A).ClampToLimit(share);
  // A start beyond a limit comes back into it only further on.
  return share >= 0 && Fits(limit, start_A, step_A, share) ? share : -1;
}

double FeasibleScale(const ForceLimit& limit, const Vec3& force_N) noexcept {
  const double norm_N = Norm(force_N);
  if (!limit.valid || !(norm_N <= kForceMax_N && limit.force_max_N >= 0)) return 0;
  if (norm_N == 0) return 1;
  const double most = std::min(1.0, limit.force_max_N / norm_N);
  const Currents push_A = Push(limit, force_N);
  const double small = limit.bias_fade_N / norm_N;  // below: not all of the bias
  if (most >= small) {
    const double scale = LargestShare(limit, limit.bias_A, push_A, most);
    if (scale >= small) return scale;
  }
  return ScaleOfSmall(limit, force_N, push_A, norm_N, std::min(most, small));
}

Vec3 Rendered_N(const ForceLimit& limit, const Vec3& force_N) noexcept {
  if (!limit.near_singular) return force_N;
  return Multiply(limit.newton_per_ampere, Multiply(limit.ampere_per_newton, force_N));
}

double ForceMax_N(const ForceLimit& limit, const Vec3& direction) noexcept {
  const double norm = Norm(direction);
  if (!(norm > 0 && norm <= kForceMax_N)) return 0;
  const Vec3 unit = (1 / norm) * direction;
  const double asked_N = FeasibleScale(limit, limit.force_max_N * unit) * limit.force_max_N;
  return asked_N * std::max(0.0, Dot(unit, Rendered_N(limit, unit)));
}

}  // namespace omni::base
