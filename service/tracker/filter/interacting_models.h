// Several models of one motion, of which one holds at a time and another may follow [interacting multiple models; Blom,
// Bar-Shalom 1988; Bar-Shalom, Li, Kirubarajan 2001, 11.6.6]. docs/theory/tracking.md (7.3)
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace omni::tracker {

inline constexpr std::size_t kModels = 3;
using Likely = std::array<double, kModels>;                                // by model; the sum is 1
using TransitionRates = std::array<std::array<double, kModels>, kModels>;  // 1/s, from row to column; diagonal 0

template <typename Estimate>
struct Models {
  std::array<Estimate, kModels> estimate{};
  Likely likely{};
};

// The models' probabilities at the next instant, and the weights with which each estimate is mixed from the others.
struct Mixing {
  Likely likely{};
  std::array<Likely, kModels> parts{};
};

//   T_ij = (1 - exp(-r_i dt)) r_ij / r_i  (j != i),  r_i = sum_j r_ij;   c_j = sum_i T_ij mu_i,   w_ij = T_ij mu_i /
//   c_j
inline Mixing Mix(const TransitionRates& rates_1_s, double dt_s, const Likely& likely) noexcept {
  Mixing mixing;
  for (std::size_t i = 0; i < kModels; ++i) {
    double leaves_1_s = 0;
    for (const double rate_1_s : rates_1_s[i]) leaves_1_s += rate_1_s;
    const double stays = std::exp(-leaves_1_s * dt_s);
    for (std::size_t j = 0; j < kModels; ++j) {
      const double goes = leaves_1_s > 0 ? (1 - stays) * rates_1_s[i][j] / leaves_1_s : 0;
      mixing.parts[j][i] = likely[i] * (i == j ? stays : goes);
      mixing.likely[j] += mixing.parts[j][i];
    }
  }
  for (std::size_t j = 0; j < kModels; ++j) {
    for (double& part : mixing.parts[j]) part /= mixing.likely[j];
  }
  return mixing;
}

// mu_j = c_j L_j / sum c L, none below `floor`: a model of probability zero could never recover
inline void UpdateProbabilities(const Likely& log_likelihood, Likely& likely) noexcept {
  constexpr double kFloor = 1e-6;
  const double best = *std::max_element(log_likelihood.begin(), log_likelihood.end());
  double sum = 0;
  for (std::size_t j = 0; j < kModels; ++j) sum += likely[j] *= std::exp(log_likelihood[j] - best);
  double floored = 0;
  for (double& mu : likely) floored += mu = std::max(mu / sum, kFloor);
  for (double& mu : likely) mu /= floored;
}

// Before each model's own time step: advances the probabilities and mixes the estimates. mean: weighted, of estimates.
template <typename Estimate, typename Mean>
void Interact(const TransitionRates& rates_1_s, double dt_s, const Mean& mean, Models<Estimate>& models) noexcept {
  const Mixing mixing = Mix(rates_1_s, dt_s, models.likely);
  const std::array<Estimate, kModels> before = models.estimate;
  for (std::size_t j = 0; j < kModels; ++j) models.estimate[j] = mean(before, mixing.parts[j]);
  models.likely = mixing.likely;
}

// correct(j, estimate): corrects model j, and returns the log-likelihood of the measurement under it.
template <typename Estimate, typename Correct>
void CorrectEach(const Correct& correct, Models<Estimate>& models) noexcept {
  Likely log_likelihood{};
  for (std::size_t j = 0; j < kModels; ++j) log_likelihood[j] = correct(j, models.estimate[j]);
  UpdateProbabilities(log_likelihood, models.likely);
}

}  // namespace omni::tracker
