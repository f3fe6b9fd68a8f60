// What may be offered to a hand through a delayed, noisy, sampled loop. docs/theory/haptics.md, section 3.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "service/base/limits.h"
#include "service/haptics/geometry/vec_math.h"
#include "service/haptics/haptics.h"

namespace omni::haptics {

inline constexpr double kNoiseForce_N = 0.030;  // K sigma above this is felt as a buzz

// K = 0.5 b / (T/2 + delay + coil lag), and K sigma <= 30 mN   (3.1), (3.2). The delay is the measured one, where there
// is one. Zero if an input is not a number.
inline double StiffnessLimit(const Config& config, const Input& input) noexcept {
  const double position_sigma_m = input.position_sigma_m;
  const double delay_s = input.delay_s != 0 ? input.delay_s : config.delay_s;
  const double lag_s = 0.5 * base::kTickPeriod_s + delay_s + config.coil_lag_s;
  double limit = config.stiffness_max_N_m;
  if (!(delay_s >= 0 && lag_s > 0 && config.hand_damping_Ns_m >= 0 && position_sigma_m >= 0 && limit >= 0)) return 0;
  limit = std::min(limit, 0.5 * config.hand_damping_Ns_m / lag_s);
  return position_sigma_m * limit > kNoiseForce_N ? kNoiseForce_N / position_sigma_m : limit;
}

// Rendered damping passes the same delay as stiffness: no more than the hand brings itself   (3.3).
inline double DampingLimit(const Config& config) noexcept { return std::max(0.0, config.hand_damping_Ns_m); }

// Springs K_i along unit n_i add up to sum K_i n_i n_i', whose largest eigenvalue is at most
// max_i sum_j K_j |n_i . n_j|   (Gershgorin on the Gram matrix, 3.4). Factor that brings this bound under `limit`.
inline double StiffnessShare(const std::array<Vec3, kMaxContacts>& normals,
                             const std::array<double, kMaxContacts>& stiffness_N_m, int count, double limit) noexcept {
  double largest = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < static_cast<std::size_t>(count); ++j) {
      sum += stiffness_N_m[j] * std::abs(Dot(normals[i], normals[j]));
    }
    largest = std::max(largest, sum);
  }
  return largest > limit && largest > 0 ? limit / largest : 1;
}

}  // namespace omni::haptics
