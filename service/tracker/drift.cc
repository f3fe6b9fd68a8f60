#include "service/tracker/drift.h"

#include <algorithm>
#include <cmath>

#include "service/tracker/cholesky.h"
#include "service/tracker/nuisance.h"

namespace omni::tracker {
namespace {

constexpr std::size_t kStates = kDriftStates;
constexpr std::size_t kMoment = kNuisancesMax;

double Square(double x) noexcept { return x * x; }

struct Wander {
  double variance, time_s;
};

Wander WanderOf(const DriftNoise& noise, std::size_t state) noexcept {
  if (state < 3) return {Square(noise.remanence_A), noise.remanence_s};
  if (state < kMoment) return {Square(noise.ambient_T), noise.ambient_s};
  return {Square(noise.moment), noise.moment_s};
}

// Information and its gradient about the seven states, the pose eliminated at the solution of the linearised scan:
//   I = A - B H^-1 B^T,   g = -(c - B H^-1 J^T r)
// with A = [C^T C, C^T M; M^T C, M^T M], B = [C^T J; M^T J], c = [C^T r; M^T r], H = J^T J.
struct Evidence {
  std::array<double, kStates * kStates> information{};
  std::array<double, kStates> gradient{};
};

bool Gather(const Measurement& measurement, const KernelSums& sums, Evidence& evidence) noexcept {
  std::array<double, std::size_t{kParameters} * kParameters> H{};
  SmallCholesky<kParameters>::Vector Jtr{};
  for (std::size_t k = 0, e = 0; k < kParameters; ++k) {
    for (std::size_t j = 0; j <= k; ++j, ++e) H[kParameters * k + j] = H[kParameters * j + k] = sums.JtJ[e];
    Jtr[k] = sums.Jtr[k];
  }
  SmallCholesky<kParameters> factors;
  if (!factors.Factor(H.data(), kParameters, 0)) return false;
  const SmallCholesky<kParameters>::Vector step = factors.Solve(Jtr);
  std::array<SmallCholesky<kParameters>::Vector, kStates> B{}, H_B{};
  for (std::size_t a = 0; a < kStates; ++a) {
    const double* row = a < kMoment ? sums.CtJ[a] : sums.MtJ;
    std::copy_n(row, kParameters, B[a].begin());
    H_B[a] = factors.Solve(B[a]);
    evidence.gradient[a] = -(a < kMoment ? sums.Ctr[a] : sums.Mtr);
    for (std::size_t k = 0; k < kParameters; ++k) evidence.gradient[a] += B[a][k] * step[k];
  }
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      double value = a < kMoment ? measurement.nuisance_information[a * kNuisancesMax + b]
                                 : (b < kMoment ? sums.CtM[b] : sums.MtM);
      for (std::size_t k = 0; k < kParameters; ++k) value -= B[a][k] * H_B[b][k];
      evidence.information[a * kStates + b] = evidence.information[b * kStates + a] = value;
    }
  }
  return true;
}

// So many scans in a row share the model's error, share s of a reading's variance: they say no more than 1 / f of them.
//   f = 1 / (1 + (n - 1) s),   1 / n = step (|v| / length + |du/dt| / angle + 1 / time)      docs/theory/tracking.md
//   (18)
double EvidenceShare(const DriftNoise& noise, const Measurement& measurement, double step_s) noexcept {
  const auto norm = [](const std::array<double, 3>& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); };
  const double change_1_s = norm(measurement.velocity_base_m_s) / noise.same_error_m +
                            norm(measurement.axis_rate_base_1_s) / noise.same_error_rad + 1 / noise.same_error_s;
  const double repeats = std::max(1.0, 1 / (change_1_s * std::max(step_s, base::kTickPeriod_s)));
  return 1 / (1 + (repeats - 1) * measurement.systematic_share);
}

void Scale(double factor, Evidence& evidence) noexcept {
  for (double& value : evidence.information) value *= factor;
  for (double& value : evidence.gradient) value *= factor;
}

// A scan sees its three currents' own errors, variance V, on top of the states that look like them: their share is
// not evidence of the states.   docs/theory/tracking.md (17)
//   I' = I - I_c (I_cc + V^-1)^-1 I_c^T,   g' = g - I_c (I_cc + V^-1)^-1 g_c
bool AllowForCurrents(const std::array<double, base::kCoilCount>& variance_A2, Evidence& evidence) noexcept {
  constexpr std::size_t kCurrents = base::kCoilCount;
  std::array<double, kCurrents * kCurrents> S{};
  for (std::size_t a = 0; a < kCurrents; ++a) {
    if (!(variance_A2[a] > 0)) return true;  // currents are exact
    for (std::size_t b = 0; b < kCurrents; ++b) S[a * kCurrents + b] = evidence.information[a * kStates + b];
    S[a * kCurrents + a] += 1 / variance_A2[a];
  }
  if (!InvertSymmetric(kCurrents, kCurrents, S.data())) return false;
  const Evidence before = evidence;
  for (std::size_t r = 0; r < kStates; ++r) {
    std::array<double, kCurrents> share{};
    for (std::size_t a = 0; a < kCurrents; ++a) {
      for (std::size_t b = 0; b < kCurrents; ++b) {
        share[b] += before.information[r * kStates + a] * S[a * kCurrents + b];
      }
    }
    for (std::size_t b = 0; b < kCurrents; ++b) {
      evidence.gradient[r] -= share[b] * before.gradient[b];
      for (std::size_t c = 0; c < kStates; ++c) {
        evidence.information[r * kStates + c] -= share[b] * before.information[b * kStates + c];
      }
    }
  }
  return true;
}

}  // namespace

Offsets OffsetsOf(const DriftState& drift) noexcept {
  Offsets offsets;
  std::copy_n(drift.mean.begin(), 3, offsets.remanence_A.begin());
  std::copy_n(drift.mean.begin() + 3, 3, offsets.ambient_base_T.begin());
  for (std::size_t k = 0; k < 3; ++k) offsets.remanence_variance_A2[k] = drift.covariance[k * kStates + k];
  return offsets;
}

double MomentScale(const DriftState& drift) noexcept { return 1 + drift.mean[kMoment]; }

// x <- phi x, P <- phi P phi + (1 - phi^2) P0 with phi = exp(-dt / tau)   [Ornstein & Uhlenbeck 1930]
void PredictDrift(const DriftNoise& noise, double dt_s, const std::array<double, base::kCoilCount>& current_step_A,
                  DriftState& drift) noexcept {
  std::array<double, kStates> keep{};
  for (std::size_t a = 0; a < kStates; ++a) {
    const Wander wander = WanderOf(noise, a);
    keep[a] = drift.valid ? std::exp(-std::max(dt_s, 0.0) / wander.time_s) : 0;
    drift.mean[a] *= keep[a];
  }
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b < kStates; ++b) drift.covariance[a * kStates + b] *= keep[a] * keep[b];
    drift.covariance[a * kStates + a] += (1 - Square(keep[a])) * WanderOf(noise, a).variance;
  }
  for (std::size_t k = 0; k < current_step_A.size() && drift.valid; ++k) {
    double& variance = drift.covariance[k * kStates + k];
    const double room = std::max(0.0, 1 - variance / WanderOf(noise, k).variance);
    variance += std::min(1.0, Square(noise.current_step_error * current_step_A[k]) / WanderOf(noise, k).variance) *
                room * WanderOf(noise, k).variance;
  }
  drift.step_s = dt_s;
  drift.valid = true;
}

void AllowForDrift(const Model& model, const DriftState& drift, Measurement& measurement) noexcept {
  const auto variance = [&drift](std::size_t a) { return drift.covariance[a * kStates + a]; };
  const auto& of_scan = measurement.current_variance_A2;
  SetNuisances(model, {variance(0) + of_scan[0], variance(1) + of_scan[1], variance(2) + of_scan[2]}, variance(3),
               measurement);
  NuisanceMatrix prior{};
  for (std::size_t a = 0; a < kNuisancesMax; ++a) {
    for (std::size_t b = 0; b < kNuisancesMax; ++b) prior[a * kNuisancesMax + b] = drift.covariance[a * kStates + b];
    if (a < of_scan.size()) prior[a * kNuisancesMax + a] += of_scan[a];
  }
  SetNuisancePrior(prior, measurement);
}

// Prior and evidence add up: P' = (P^-1 + I)^-1, x' = x + P' g   [information form of Kalman's correction]. The scan
// was linearised with the prior mean already taken off, so that the prior pulls towards no change.
bool CorrectDrift(const DriftNoise& noise, const Measurement& measurement, const KernelSums& sums,
                  DriftState& drift) noexcept {
  Evidence evidence;
  if (!Gather(measurement, sums, evidence)) return false;
  if (!AllowForCurrents(measurement.current_variance_A2, evidence)) return false;
  Scale(EvidenceShare(noise, measurement, drift.step_s), evidence);
  auto P = drift.covariance;
  if (!InvertSymmetric(kDriftStates, kDriftStates, P.data())) return false;
  for (std::size_t e = 0; e < P.size(); ++e) P[e] += evidence.information[e];
  if (!InvertSymmetric(kDriftStates, kDriftStates, P.data())) return false;
  std::array<double, kStates> mean = drift.mean;
  double sum = 0;
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b < kStates; ++b) mean[a] += P[a * kStates + b] * evidence.gradient[b];
    sum += mean[a];
  }
  if (!std::isfinite(sum)) return false;
  drift.mean = mean;
  drift.mean[kMoment] = std::clamp(drift.mean[kMoment], -noise.moment_max, noise.moment_max);
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b < kStates; ++b) {
      drift.covariance[a * kStates + b] = 0.5 * (P[a * kStates + b] + P[b * kStates + a]);
    }
  }
  return true;
}

}  // namespace omni::tracker
