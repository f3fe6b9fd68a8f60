#include "service/haptics/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "service/base/limits.h"

namespace omni::haptics {
namespace {

constexpr double kNoiseForce_N = 0.020;     // N, of K sigma and B sigma_v; more is a noticeable buzz
constexpr double kGainMargin = 2;           // 6 dB
constexpr double kHandStiffness_N_m = 150;  // [Hajian & Howe 1997: fingers and wrist]
constexpr std::array kHandMasses_kg = {0.05, 0.2};
constexpr double kWorthIt = 1.2;
constexpr double kPredictTime_s = 0.05, kLimitTime_s = 0.2, kRiseTime_s = 0.02;
constexpr double kRenewInTouch_s = 4e-3, kRenewInAir_s = 50e-3;  // a far tip costs nothing

// The lag that is left over at low frequencies, and the terms that prediction and filter add at higher ones:
// H(s) exp(-D s) = 1 - left s - ... , arg = -(left w + phase w^3), |H| = 1 + gain w^2, for a constant-velocity filter
// of natural frequency w_n that is extrapolated by p:  H = (1 + (p + a) s) / (1 + a s + s^2 / w_n^2), a = sqrt(2) /
// w_n.
struct Lead {
  double left_s = 0, gain_s2 = 0, phase_s3 = 0;
};

Lead LeadOf(double lag_s, double predict_s, double filter_s2) noexcept {
  const double a = std::sqrt(2 * filter_s2);
  const double q = predict_s + a;
  return {std::max(0.0, lag_s - predict_s), 0.5 * q * q, (q * q * q - a * a * a) / 3 + a * filter_s2};
}

// Stiffness at which a hand of mass m, damping b and stiffness k on this loop just oscillates: at the crossover
// w^2 = (x + k) / m the hand's phase lead b w / x equals the lag, with x = K |H|; a quadratic in x.
double CriticalStiffness(const Lead& lead, double mass_kg, double damping_Ns_m) noexcept {
  const double a = lead.phase_s3 / mass_kg;
  const double b = lead.left_s + a * kHandStiffness_N_m;
  const double x = 2 * damping_Ns_m / (b + std::sqrt(b * b + 4 * a * damping_Ns_m));
  const double w2 = (x + kHandStiffness_N_m) / mass_kg;
  return x / (1 + lead.gain_s2 * w2);
}

// Largest K with K sigma = N sqrt(1 - K / K_c): near the K_c at which the hand just oscillates, 1 - K / K_c of its
// damping is left, and its resonance answers noise by the root of what it lost.  (3.4)
double NoiseLimit(double sigma_m, double critical_N_m) noexcept {
  if (!(sigma_m > 0)) return std::numeric_limits<double>::infinity();
  const double plain_N_m = kNoiseForce_N / sigma_m, ratio = plain_N_m / critical_N_m;
  return 2 * plain_N_m / (ratio + std::sqrt(ratio * ratio + 4));
}

double Approach(double from, double to, double dt_s, double time_s) noexcept {
  return from + (to - from) * std::min(1.0, dt_s / time_s);
}

bool IsPlausible(const base::PointNoise& noise) noexcept {
  return noise.position_m2 >= 0 && noise.position_m2 < 1 && std::abs(noise.cross_m2_s) < 1e3 &&
         noise.velocity_m2_s2 >= 0 && noise.velocity_m2_s2 < 1e6;
}

// In contact only down; in the air towards the limit.
void Follow(double limit_N_m, bool known, bool touching, double dt_s, double& recent_N_m, double& bound_N_m) noexcept {
  recent_N_m = known && limit_N_m > 0 ? Approach(recent_N_m, limit_N_m, dt_s, kLimitTime_s) : limit_N_m;
  if (!known || recent_N_m < bound_N_m) {
    bound_N_m = recent_N_m;
  } else if (!touching) {
    bound_N_m = Approach(bound_N_m, recent_N_m, dt_s, kRiseTime_s);
  }
}

// The hand's own, or what noise leaves of it: B sigma_v is a force as well   (3.6)
double DampingLimit(const Config& config, const base::PointNoise& noise) noexcept {
  const double sigma_m_s = std::sqrt(noise.velocity_m2_s2);
  const double hand_Ns_m = std::max(0.0, config.hand_damping_Ns_m);
  return sigma_m_s * hand_Ns_m > kNoiseForce_N ? kNoiseForce_N / sigma_m_s : hand_Ns_m;
}

// `dt_s`: since the last time.
void Renew(const Config& config, const Input& input, bool touching, double dt_s, StiffnessBoundState& state) noexcept {
  if (!touching || !state.known) {
    const double best_s = BestPrediction_s(config, input);
    state.predict_s = state.known ? Approach(state.predict_s, best_s, dt_s, kPredictTime_s) : best_s;
  }
  const double worst_N_m = StiffnessLimit(config, input, input.noise, state.predict_s);
  const bool uniform = input.axis_base == Vec3{};
  const double along_N_m = uniform ? worst_N_m : StiffnessLimit(config, input, input.noise_along, state.predict_s);
  Follow(worst_N_m, state.known, touching, dt_s, state.recent_N_m, state.stiffness_N_m);
  Follow(std::max(worst_N_m, along_N_m), state.known, touching, dt_s, state.recent_along_N_m, state.along_N_m);
  const double damping_Ns_m = DampingLimit(config, input.noise);
  state.damping_Ns_m = state.known ? Approach(state.damping_Ns_m, damping_Ns_m, dt_s, kLimitTime_s) : damping_Ns_m;
  state.known = true;
}

}  // namespace

double LoopLag_s(const Config& config, const Input& input) noexcept {
  const double delay_s = input.delay_s != 0 ? input.delay_s : config.delay_s;
  const double lag_s = 0.5 * base::kTickPeriod_s + delay_s + config.coil_lag_s;
  return delay_s >= 0 && lag_s > 0 && lag_s < 1 ? lag_s : std::numeric_limits<double>::quiet_NaN();
}

// K sigma is what noise allows, and sigma_n^2 = c^2 sigma_along^2 + (1 - c^2) sigma_worst^2, c = n . axis.
double StiffnessAlong(const StiffnessBound& bound, const Vec3& direction) noexcept {
  if (!(bound.stiffness_N_m > 0 && bound.along_N_m > bound.stiffness_N_m)) return bound.stiffness_N_m;
  const double c = Dot(direction, bound.axis_base), share = std::clamp(c * c, 0.0, 1.0);
  const double ratio = bound.stiffness_N_m / bound.along_N_m;
  return bound.stiffness_N_m / std::sqrt(share * ratio * ratio + (1 - share));
}

double StiffnessLimit(const Config& config, const Input& input, const base::PointNoise& noise,
                      double predict_s) noexcept {
  const double lag_s = LoopLag_s(config, input);
  const double damping_Ns_m = config.hand_damping_Ns_m;
  if (!(lag_s > 0 && damping_Ns_m >= 0 && config.stiffness_max_N_m >= 0 && IsPlausible(noise))) return 0;
  const auto& [position_m2, cross_m2_s, velocity_m2_s2] = noise;
  double limit_N_m = 0.5 * damping_Ns_m / lag_s;                    // (3.2)
  if (predict_s > 0 && (velocity_m2_s2 > 0 || position_m2 == 0)) {  // (3.3)
    const Lead lead = LeadOf(lag_s, predict_s, position_m2 > 0 ? position_m2 / velocity_m2_s2 : 0);
    double critical_N_m = std::numeric_limits<double>::infinity();
    for (const double mass_kg : kHandMasses_kg) {
      critical_N_m = std::min(critical_N_m, CriticalStiffness(lead, mass_kg, damping_Ns_m));
    }
    limit_N_m = std::max(limit_N_m, critical_N_m / kGainMargin);
  }
  const double variance_m2 = position_m2 + 2 * predict_s * cross_m2_s + predict_s * predict_s * velocity_m2_s2;
  const double sigma_m = std::sqrt(std::max(position_m2, variance_m2));
  const double noise_N_m = NoiseLimit(std::sqrt(position_m2), kGainMargin * limit_N_m);  // (3.4)
  limit_N_m = std::min({limit_N_m, config.stiffness_max_N_m, noise_N_m});
  return sigma_m * limit_N_m > kNoiseForce_N ? kNoiseForce_N / sigma_m : limit_N_m;
}

double BestPrediction_s(const Config& config, const Input& input) noexcept {
  const double lag_s = LoopLag_s(config, input);
  if (!(lag_s > 0)) return 0;
  double best_s = 0;
  double best_N_m = kWorthIt * StiffnessLimit(config, input, input.noise, 0);
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    const double predict_s = std::min(share * lag_s, config.predict_max_s);
    const double limit_N_m = StiffnessLimit(config, input, input.noise, predict_s);
    if (!(limit_N_m > best_N_m)) continue;
    best_N_m = limit_N_m;
    best_s = predict_s;
  }
  return best_s;
}

StiffnessBound UpdateStiffnessBound(const Config& config, const Input& input, bool touching,
                                    StiffnessBoundState& state) noexcept {
  const double lag_s = LoopLag_s(config, input);
  if (!(lag_s > 0) || !IsPlausible(input.noise)) return {};
  state.age_s += input.dt_s;
  if (!state.known || state.age_s >= (touching ? kRenewInTouch_s : kRenewInAir_s)) {
    Renew(config, input, touching, state.age_s, state);
    state.age_s = 0;
  }
  StiffnessBound bound = StiffnessBoundOf(input.axis_base, state);
  bound.ahead_s = std::max(0.0, lag_s - bound.predict_s);
  bound.coil_lag_s = config.coil_lag_s;
  return bound;
}

StiffnessBound StiffnessBoundOf(const Vec3& axis_base, const StiffnessBoundState& state) noexcept {
  return {.stiffness_N_m = state.stiffness_N_m,
          .along_N_m = state.along_N_m,
          .axis_base = axis_base,
          .damping_Ns_m = state.damping_Ns_m,
          .predict_s = state.predict_s};
}

double StiffnessShare(const std::array<Vec3, kMaxContacts>& normals,
                      const std::array<double, kMaxContacts>& load) noexcept {
  double largest = 0;
  for (std::size_t i = 0; i < kMaxContacts; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < kMaxContacts; ++j) sum += load[j] * std::abs(Dot(normals[i], normals[j]));
    largest = std::max(largest, sum);
  }
  return largest > 1 ? 1 / largest : 1;
}

}  // namespace omni::haptics
