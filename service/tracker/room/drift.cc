#include "service/tracker/room/drift.h"

#include <algorithm>
#include <cmath>

#include "service/base/stamp.h"
#include "service/tracker/kernel/cholesky.h"

namespace omni::tracker {
namespace {

constexpr std::size_t kStates = kDriftStates;
constexpr std::size_t kMoment = kNuisancesMax;
constexpr std::size_t kAmbient = base::kCoilCount;         // the first of three
constexpr double kMemory = 0.1;                            // share of the newest innovation in the mean of those before
constexpr double kMoves = 0.1, kModelLasts = 0.6;          // of that mean, squared: the wander grows ...
constexpr double kWanderGrows = 2, kWanderShrinks = 0.98;  // ... by so much
constexpr double kCurrentStepMax_A = 1e3, kForgetMax_s = 1e6;
constexpr double kJump = 10;  // of one innovation: once in a million, were it no jump

using StateRow = DriftEvidence::Row;

void AddTo(StateRow& row, double factor, const StateRow& other) noexcept {
  for (std::size_t a = 0; a < row.size(); ++a) row[a] += factor * other[a];
}

double Square(double x) noexcept { return x * x; }

// follows: the core's string has been followed
double VarianceOf(const DriftNoise& noise, bool follows, std::size_t state) noexcept {
  if (state < 3 && follows) return Square(std::max(noise.core_error * noise.core_kept_A, noise.core_error_min_A));
  if (state < 3) return Square(noise.remanence_A);
  return state < kMoment ? Square(noise.ambient_T) : Square(noise.moment);
}

// Information and its gradient about the seven states, the pose eliminated at the solution of the linearised scan:
//   I = A - B H^-1 B^T,   g = -(c - B H^-1 J^T r)
// with A = [C^T C, C^T M; M^T C, M^T M], B = [C^T J; M^T J], c = [C^T r; M^T r], H = J^T J.
bool EliminatePose(const Measurement& measurement, const KernelSums& sums, DriftEvidence& evidence) noexcept {
  std::array<double, std::size_t{kParameters} * kParameters> H;
  std::array<StateRow, kParameters> B{};
  const double per_scale = 1 / measurement.moment_scale;  // M is of the field as scaled, the state is the scale
  for (std::size_t k = 0, e = 0; k < kParameters; ++k) {
    for (std::size_t j = 0; j <= k; ++j, ++e) H[kParameters * k + j] = sums.JtJ[e];
    for (std::size_t a = 0; a < kMoment; ++a) B[k][a] = sums.CtJ[a][k];
    B[k][kMoment] = per_scale * sums.MtJ[k];
  }
  SmallCholesky<kParameters> factors;
  if (!factors.Factor(H.data(), kParameters, 0)) return false;
  std::array<StateRow, kParameters> H_B = B;
  factors.SolveSides(H_B);
  for (std::size_t a = 0; a < kStates; ++a) {
    StateRow& row = evidence.information[a];
    for (std::size_t b = 0; b < kMoment; ++b) {
      row[b] = a < kMoment ? measurement.nuisance_information[a * kNuisancesMax + b] : per_scale * sums.CtM[b];
    }
    row[kMoment] = per_scale * (a < kMoment ? sums.CtM[a] : per_scale * sums.MtM);
    for (std::size_t k = 0; k < kParameters; ++k) AddTo(row, -B[k][a], H_B[k]);
    evidence.gradient[a] = -(a < kMoment ? sums.Ctr[a] : per_scale * sums.Mtr);
  }
  for (std::size_t k = 0; k < kParameters; ++k) evidence.pose_per_moment[k] = -H_B[k][kMoment];
  for (std::size_t k = 0; k < kParameters; ++k) AddTo(evidence.gradient, sums.Jtr[k], H_B[k]);
  return true;
}

// A scan sees its three currents' own errors, variance V, on top of the states that look like them: their share is
// not evidence of the states.   docs/theory/tracking.md (17)
//   I' = I - I_c (I_cc + V^-1)^-1 I_c^T,   g' = g - I_c (I_cc + V^-1)^-1 g_c
bool AllowForCurrents(DriftEvidence& evidence) noexcept {
  const auto& variance_A2 = evidence.current_variance_A2;
  constexpr std::size_t kCurrents = base::kCoilCount;
  std::array<double, kCurrents * kCurrents> S{};
  for (std::size_t a = 0; a < kCurrents; ++a) {
    if (!(variance_A2[a] > 0)) return true;  // currents are exact
    for (std::size_t b = 0; b < kCurrents; ++b) S[a * kCurrents + b] = evidence.information[a][b];
    S[a * kCurrents + a] += 1 / variance_A2[a];
  }
  if (!InvertPositive<kCurrents>(S.data(), kCurrents)) return false;
  std::array<StateRow, kCurrents> share{};  // (I_cc + V^-1)^-1 I_c^T
  for (std::size_t a = 0; a < kCurrents; ++a) {
    for (std::size_t b = 0; b < kCurrents; ++b) AddTo(share[a], S[a * kCurrents + b], evidence.information[b]);
  }
  const DriftEvidence before = evidence;
  for (std::size_t c = 0; c < kCurrents; ++c) {
    for (std::size_t r = 0; r < kStates; ++r) AddTo(evidence.information[r], -before.information[r][c], share[c]);
    AddTo(evidence.gradient, -before.gradient[c], share[c]);
  }
  return true;
}

//   I_m = I_aa - I_ao (I_oo + D^-1)^-1 I_oa,   g_m = g_a - I_ao (I_oo + D^-1)^-1 g_o
AmbientEvidence OfAmbient(const DriftEvidence& evidence, const DriftState& drift) noexcept {
  AmbientEvidence ambient;
  constexpr std::size_t kOthers = kStates - 3;
  constexpr std::array<std::size_t, kOthers> others{0, 1, 2, kMoment};
  std::array<double, kOthers * kOthers> S;
  for (std::size_t a = 0; a < kOthers; ++a) {
    for (std::size_t b = 0; b < kOthers; ++b) S[kOthers * a + b] = evidence.information[others[a]][others[b]];
    S[(kOthers + 1) * a] += 1 / drift.covariance[others[a] * (kStates + 1)];
  }
  if (!InvertPositive<kOthers>(S.data(), kOthers)) return ambient;
  for (std::size_t a = 0; a < 3; ++a) {
    const StateRow& row = evidence.information[kAmbient + a];
    std::array<double, kOthers> weight{};  // I_ao (I_oo + D^-1)^-1
    for (std::size_t c = 0; c < kOthers; ++c) {
      for (std::size_t d = 0; d < kOthers; ++d) weight[c] += row[others[d]] * S[kOthers * d + c];
    }
    ambient.gradient[a] = evidence.gradient[kAmbient + a];
    for (std::size_t c = 0; c < kOthers; ++c) ambient.gradient[a] -= weight[c] * evidence.gradient[others[c]];
    for (std::size_t b = 0; b < 3; ++b) {
      double sum = row[kAmbient + b];
      for (std::size_t c = 0; c < kOthers; ++c) sum -= weight[c] * evidence.information[others[c]][kAmbient + b];
      ambient.information[3 * a + b] = sum;
    }
  }
  ambient.valid = true;
  return ambient;
}

// Removes row and column `state` but for its variance.
void Isolate(std::size_t state, double variance, DriftMatrix& covariance) noexcept {
  for (std::size_t b = 0; b < kStates; ++b) covariance[state * kStates + b] = covariance[b * kStates + state] = 0;
  covariance[state * (kStates + 1)] = variance;
}

// Squared innovation over the expected one, mean of three components: with nu = I^-1 g the field's innovation,
//   nu^T (I^-1 + P)^-1 nu / 3 = g^T (I + I P I)^-1 g / 3
double Innovation(const AmbientEvidence& evidence, const DriftState& drift) noexcept {
  const auto& I = evidence.information;
  std::array<double, 9> S;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      double sum = I[3 * a + b];
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t d = 0; d < 3; ++d) {
          sum += I[3 * a + c] * drift.covariance[(kAmbient + c) * kStates + kAmbient + d] * I[3 * d + b];
        }
      }
      S[3 * a + b] = sum;
    }
  }
  if (!InvertPositive<3>(S.data(), 3)) return 0;
  double sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) sum += evidence.gradient[a] * S[3 * a + b] * evidence.gradient[b];
  }
  return std::isfinite(sum) ? sum / 3 : 0;
}

// A jump opens the field. Correlated innovations mean that it moves: their mean would be small otherwise. The model's
// own error, which lasts too, is allowed for.
void LearnWander(const DriftNoise& noise, const AmbientEvidence& now, double systematic_share,
                 DriftState& drift) noexcept {
  if (!now.valid) return;
  if (Innovation(now, drift) > kJump) return OpenAmbient(noise, drift);
  AmbientEvidence recent{true, drift.recent_information, drift.recent_gradient};
  for (std::size_t a = 0; a < 9; ++a) recent.information[a] += kMemory * (now.information[a] - recent.information[a]);
  for (std::size_t a = 0; a < 3; ++a) recent.gradient[a] += kMemory * (now.gradient[a] - recent.gradient[a]);
  drift.recent_information = recent.information;
  drift.recent_gradient = recent.gradient;
  const double lasting = Innovation(recent, drift) / (kMoves + kModelLasts * systematic_share);
  double& wander = drift.ambient_wander_T2_s;
  if (lasting > 1) {
    wander = std::clamp(kWanderGrows * wander, 2 * noise.ambient_wander_min_T2_s, noise.ambient_wander_max_T2_s);
  } else if (lasting < 0.5) {
    wander *= kWanderShrinks;
    if (wander < noise.ambient_wander_min_T2_s) wander = 0;
  }
}

double AmbientVariance(const DriftState& drift, std::size_t axis) noexcept {
  return drift.covariance[(kAmbient + axis) * (kStates + 1)];
}

double WorstAmbientVariance(const DriftState& drift) noexcept {
  return std::max({AmbientVariance(drift, 0), AmbientVariance(drift, 1), AmbientVariance(drift, 2)});
}

bool IsAmbientOpen(const DriftNoise& noise, const DriftState& drift) noexcept {
  return WorstAmbientVariance(drift) > Square(noise.ambient_open_T);
}

void SetAmbientVariance(double variance_T2, DriftMatrix& covariance) noexcept {
  for (std::size_t a = kAmbient; a < kAmbient + 3; ++a) Isolate(a, variance_T2, covariance);
}

void SetAmbientVariance(double variance_T2, DriftState& drift) noexcept {
  SetAmbientVariance(variance_T2, drift.covariance);
  drift.recent_information = {};
  drift.recent_gradient = {};
}

}  // namespace

// A play operator: x is dragged behind the core's moment m like a stone on a string,   x <- d min(1, k / |d|),   d = x
// - dm        (34)
void FollowCore(const DriftNoise& noise, const std::array<double, base::kCoilCount>& coil_current_A,
                const PenPlace* pen, DriftState& drift) noexcept {
  const bool known = noise.core_kept_A > 0 && pen != nullptr, follows = known && drift.core_followed;
  drift.core_followed = known;
  if (!known) return;
  const std::array<double, 3> before_A = drift.core_A, by_pen_A{pen->core_A.x, pen->core_A.y, pen->core_A.z};
  for (std::size_t k = 0; k < 3; ++k) drift.core_A[k] = by_pen_A[k] + noise.coil_core_share * coil_current_A[k];
  if (!follows) return;
  double square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    drift.mean[k] -= drift.core_A[k] - before_A[k];
    square += Square(drift.mean[k]);
  }
  const double string = noise.core_kept_A / std::max(std::sqrt(square), noise.core_kept_A);
  for (std::size_t k = 0; k < 3; ++k) drift.mean[k] *= string;
}

bool IsAmbientLively(const DriftNoise& noise, const DriftState& drift) noexcept {
  return drift.ambient_wander_T2_s > 0 || IsAmbientOpen(noise, drift);
}

// The model's error where the pen lies stays as it was.
void OpenAmbient(const DriftNoise& noise, DriftState& drift) noexcept {
  const double variance_T2 = Square(noise.ambient_jump_T);
  SetAmbientVariance(variance_T2, drift);
  if (drift.still.referenced) {
    SetAmbientVariance(variance_T2, drift.still.covariance);
    drift.still.gathers = false;
  } else {
    drift.still = {};
  }
}

void SetAmbient(const std::array<double, 3>& ambient_base_T, double variance_T2, DriftState& drift) noexcept {
  std::copy(ambient_base_T.begin(), ambient_base_T.end(), drift.mean.begin() + kAmbient);
  SetAmbientVariance(variance_T2, drift);
  drift.still = {};
}

void WidenAmbient(double variance_T2, DriftState& drift) noexcept {
  if (WorstAmbientVariance(drift) >= variance_T2) return;
  SetAmbientVariance(variance_T2, drift);
  drift.still = {};
}

//   1 / n = step (|v| / length + |du/dt| / angle + 1 / time)      docs/theory/tracking.md (18)
double RepeatsOf(const DriftNoise& noise, const Measurement& measurement, double step_s) noexcept {
  const auto norm = [](const std::array<double, 3>& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); };
  const double change_1_s = norm(measurement.velocity_base_m_s) / noise.same_error_m +
                            norm(measurement.axis_rate_base_1_s) / noise.same_error_rad + 1 / noise.same_error_s;
  return std::max(1.0, 1 / (change_1_s * std::max(step_s, base::kTickPeriod_s)));
}

//   f = 1 / (1 + (n - 1) s)
double EvidenceShare(double repeats, double systematic) noexcept {
  return 1 / (1 + std::max(0.0, repeats - 1) * systematic);
}

Offsets OffsetsOf(const DriftNoise& noise, const DriftState& drift) noexcept {
  Offsets offsets;
  std::copy_n(drift.mean.begin(), 3, offsets.remanence_A.begin());
  offsets.ambient_base_T = AmbientField_T(drift);
  for (std::size_t k = 0; k < 3; ++k) offsets.remanence_variance_A2[k] = drift.covariance[k * kStates + k];
  if (IsAmbientOpen(noise, drift)) {
    for (std::size_t c = 0; c < 3; ++c) offsets.ambient_variance_T2[c] = AmbientVariance(drift, c);
  }
  return offsets;
}

double MomentScale(const DriftState& drift) noexcept { return 1 + drift.mean[kMoment]; }
double MomentVariance(const DriftState& drift) noexcept { return drift.covariance[kMoment * (kStates + 1)]; }

void SetMoment(double relative, double variance, DriftState& drift) noexcept {
  drift.mean[kMoment] = drift.moment_of_pen = relative;
  drift.moment_open = true;
  Isolate(kMoment, variance, drift.covariance);
  drift.still = {};
}

//   x <- x + K (z - x_m),   P <- P - K P_m,   K = P_m / (P_mm + R)
void ObserveMoment(double relative, double variance, DriftState& drift) noexcept {
  const double innovation = relative - drift.mean[kMoment];
  StateRow column{};
  for (std::size_t a = 0; a < kStates; ++a) column[a] = drift.covariance[a * kStates + kMoment];
  const double expected = column[kMoment] + variance;
  if (!(expected > 0)) return;
  for (std::size_t a = 0; a < kStates; ++a) {
    drift.mean[a] += column[a] / expected * innovation;
    for (std::size_t b = 0; b < kStates; ++b) drift.covariance[a * kStates + b] -= column[a] * column[b] / expected;
  }
  drift.still = {};
}

void HoldMoment(double relative, DriftState& drift) noexcept {
  drift.moment_of_pen = relative;
  drift.moment_open = false;
}

//   I_m = I_mm - I_mo (I_oo + D^-1)^-1 I_om,   g_m = g - I_mo (I_oo + D^-1)^-1 g_o
MomentEvidence OfMoment(DriftEvidence evidence, const DriftState& drift) noexcept {
  MomentEvidence moment;
  if (!evidence.valid || !AllowForCurrents(evidence)) return moment;
  constexpr std::size_t kOthers = kMoment;
  std::array<double, kOthers * kOthers> S;
  for (std::size_t a = 0; a < kOthers; ++a) {
    for (std::size_t b = 0; b < kOthers; ++b) S[kOthers * a + b] = evidence.information[a][b];
    S[(kOthers + 1) * a] += 1 / drift.covariance[a * (kStates + 1)];
  }
  if (!InvertPositive<kOthers>(S.data(), kOthers)) return moment;
  const StateRow& row = evidence.information[kMoment];
  moment.information = row[kMoment];
  moment.gradient = evidence.gradient[kMoment];
  for (std::size_t a = 0; a < kOthers; ++a) {
    for (std::size_t b = 0; b < kOthers; ++b) {
      moment.information -= row[a] * S[kOthers * a + b] * row[b];
      moment.gradient -= row[a] * S[kOthers * a + b] * evidence.gradient[b];
    }
  }
  moment.valid = moment.information > 0 && std::isfinite(moment.information + moment.gradient);
  return moment;
}
std::array<double, 3> AmbientField_T(const DriftState& drift) noexcept {
  return {drift.mean[kAmbient], drift.mean[kAmbient + 1], drift.mean[kAmbient + 2]};
}

// x <- phi x (but the ambient field stays where it is), P <- phi P phi + (1 - phi^2) P0 with phi = exp(-dt / tau)
// [Ornstein & Uhlenbeck 1930]; the covariance of changes grows as P does, but slower where one pose carries little
// information.
void PredictDrift(const DriftNoise& noise, double dt_s, const std::array<double, base::kCoilCount>& current_step_A,
                  const PenPlace* pen, DriftState& drift) noexcept {
  dt_s = std::max(dt_s, 0.0);
  const auto keep_of = [&](double times) { return drift.valid ? std::exp(-times) : 0.0; };
  const double remanence = keep_of(ForgottenOf(noise.still, dt_s, pen, noise.core_kept_A, drift.still));
  const double ambient = keep_of(dt_s / noise.ambient_s), moment = keep_of(dt_s / noise.moment_s);
  const DriftVector keep{remanence, remanence, remanence, ambient, ambient, ambient, moment};
  const bool follows = drift.valid && drift.core_followed;
  for (std::size_t k = 0; k < kAmbient && !follows; ++k) drift.mean[k] *= keep[k];
  drift.mean[kMoment] = drift.moment_of_pen + keep[kMoment] * (drift.mean[kMoment] - drift.moment_of_pen);
  DriftVector grows{};
  for (std::size_t a = 0; a < kStates; ++a) grows[a] = (1 - Square(keep[a])) * VarianceOf(noise, follows, a);
  for (std::size_t a = kAmbient; a < kAmbient + 3; ++a) grows[a] += dt_s * drift.ambient_wander_T2_s;
  for (std::size_t k = 0; k < current_step_A.size() && drift.valid; ++k) {
    const double most = VarianceOf(noise, follows, k);
    const double room = std::max(0.0, 1 - (Square(keep[k]) * drift.covariance[k * (kStates + 1)] + grows[k]) / most);
    grows[k] += std::min(most, Square(noise.current_step_error * current_step_A[k])) * room;
  }
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b < kStates; ++b) drift.covariance[a * kStates + b] *= keep[a] * keep[b];
    drift.covariance[a * (kStates + 1)] += grows[a];
    const double slower = a < kAmbient ? 1 : a == kMoment ? noise.moment_still : noise.ambient_still;
    drift.still.covariance[a * (kStates + 1)] += slower * grows[a];
  }
  drift.step_s = dt_s;
  drift.valid = true;
}

void PredictDriftTo(const DriftNoise& noise, std::int64_t t_ns,
                    const std::array<double, base::kCoilCount>& coil_current_A, const PenPlace* pen,
                    DriftState& drift) noexcept {
  std::array<double, base::kCoilCount> step_A{};
  double sum_A = 0;
  for (std::size_t k = 0; k < step_A.size(); ++k) {
    step_A[k] = coil_current_A[k] - drift.coil_current_A[k];
    sum_A += std::abs(step_A[k]);
  }
  const bool plausible = sum_A <= kCurrentStepMax_A;
  if (!plausible) step_A = {};
  PredictDrift(noise, std::clamp(base::Elapsed_s(t_ns, drift.t_ns), 0.0, kForgetMax_s), step_A, pen, drift);
  drift.t_ns = t_ns;
  if (plausible) drift.coil_current_A = coil_current_A;
}

DriftEvidence GatherEvidence(const DriftNoise& noise, const Measurement& measurement, const KernelSums& sums,
                             double step_s) noexcept {
  DriftEvidence evidence;
  evidence.valid = EliminatePose(measurement, sums, evidence);
  evidence.share = EvidenceShare(RepeatsOf(noise, measurement, step_s), measurement.systematic_share);
  evidence.systematic_share = measurement.systematic_share;
  evidence.current_variance_A2 = measurement.current_variance_A2;
  for (const double age_s : measurement.age_s) evidence.age_s += age_s / static_cast<double>(kSensors);
  return evidence;
}

// Prior and evidence are combined: P' = (P^-1 + I)^-1, x' = x + P' g   [information form of Kalman's correction]. The
// scan was linearised with the prior mean already subtracted, so that the prior pulls towards no change.
AmbientEvidence CorrectDrift(const DriftNoise& noise, DriftEvidence evidence, DriftState& drift) noexcept {
  if (!evidence.valid || !AllowForCurrents(evidence)) return {};
  TellChange(noise.still, drift.covariance, drift.still, evidence);
  const AmbientEvidence ambient = OfAmbient(evidence, drift);
  LearnWander(noise, ambient, evidence.systematic_share, drift);
  DriftMatrix& covariance = drift.still.referenced ? drift.still.covariance : drift.covariance;
  DriftMatrix P = covariance;
  if (!InvertPositive<kDriftStates>(P.data(), kDriftStates)) return {};
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b < kStates; ++b) P[a * kStates + b] += evidence.share * evidence.information[a][b];
  }
  if (!InvertPositive<kDriftStates>(P.data(), kDriftStates)) return {};
  DriftVector mean = drift.mean;
  double sum = 0;
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b < kStates; ++b) {
      mean[a] += P[a * kStates + b] * evidence.share * evidence.gradient[b];
    }
    sum += mean[a];
  }
  if (!std::isfinite(sum)) return {};
  drift.mean = mean;
  const double pen = drift.moment_open ? 0 : drift.moment_of_pen;
  const double most = drift.moment_open ? noise.moment_open_max : noise.moment_max;
  drift.mean[kMoment] = std::clamp(drift.mean[kMoment], pen - most, pen + most);
  covariance = P;
  for (std::size_t e = 0; e < P.size() && drift.still.referenced; ++e) {
    drift.covariance[e] = drift.still.reference_covariance[e] + P[e];
  }
  return ambient;
}

}  // namespace omni::tracker
