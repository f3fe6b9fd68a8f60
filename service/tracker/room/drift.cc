#include "service/tracker/room/drift.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"
#include "service/tracker/kernel/cholesky.h"
#include "service/tracker/kernel/matrices.h"

namespace omni::tracker {
namespace {

constexpr int kStates = kDriftStates, kCurrents = base::kCoilCount;
constexpr int kMoment = kNuisancesMax;
constexpr int kAmbient = base::kCoilCount;                 // the first of three
constexpr double kMemory = 0.1;                            // share of the newest innovation in the mean of those before
constexpr double kMoves = 0.1, kModelLasts = 0.6;          // of that mean, squared: the wander grows ...
constexpr double kWanderGrows = 2, kWanderShrinks = 0.98;  // ... by so much
constexpr double kForgetMax_s = 1e6;
constexpr double kJump = 10;  // of one innovation: once in a million, were it no jump

using StateMatrix = Matrix<kStates>;
using StateVector = Matrix<kStates, 1>;

double Square(double x) noexcept { return x * x; }

// follows: the core's string has been followed
double VarianceOf(const DriftNoise& noise, bool follows, int state) noexcept {
  if (state < 3 && follows) return Square(std::max(noise.core_error * noise.core_kept_A, noise.core_error_min_A));
  if (state < 3) return Square(noise.remanence_A);
  return state < kMoment ? Square(noise.ambient_T) : Square(noise.moment);
}

// Information and its gradient about the seven states, the pose eliminated at the solution of the linearised scan:
//   I = A - B H^-1 B^T,   g = -(c - B H^-1 J^T r)
// with A = [C^T C, C^T M; M^T C, M^T M], B = [C^T J; M^T J], c = [C^T r; M^T r], H = J^T J.
bool EliminatePose(const Measurement& measurement, const KernelSums& sums, DriftEvidence& evidence) noexcept {
  std::array<double, std::size_t{kParameters} * kParameters> H;
  std::array<std::array<double, kStates>, kParameters> sides;
  const double per_scale = 1 / measurement.moment_scale;  // M is of the field as scaled, the state is the scale
  for (std::size_t k = 0, e = 0; k < kParameters; ++k) {
    for (std::size_t j = 0; j <= k; ++j, ++e) H[kParameters * k + j] = sums.JtJ[e];
    for (std::size_t a = 0; a < kMoment; ++a) sides[k][a] = sums.CtJ[a][k];
    sides[k][kMoment] = per_scale * sums.MtJ[k];
  }
  SmallCholesky<kParameters> factors;
  if (!factors.Factor(H.data(), kParameters, 0)) return false;
  const Matrix<kParameters, kStates> B = AsRows(sides);
  factors.SolveSides(sides);
  const auto H_B = AsRows(sides);
  StateMatrix A;
  StateVector c;
  const Eigen::Map<const Matrix<kMoment, 1>> CtM(sums.CtM);
  A.topLeftCorner<kMoment, kMoment>() = AsMatrix<kMoment>(measurement.nuisance_information);
  A.topRightCorner<kMoment, 1>() = per_scale * CtM;
  A.bottomLeftCorner<1, kMoment>() = per_scale * CtM.transpose();
  A(kMoment, kMoment) = per_scale * per_scale * sums.MtM;
  c << Eigen::Map<const Matrix<kMoment, 1>>(sums.Ctr), per_scale * sums.Mtr;
  AsMatrix<kStates>(evidence.information) = A - B.transpose() * H_B;
  AsVector(evidence.gradient) = H_B.transpose() * Eigen::Map<const Matrix<kParameters, 1>>(sums.Jtr) - c;
  AsVector(evidence.pose_per_moment) = -H_B.col(kMoment);
  return true;
}

// A scan sees its three currents' own errors, variance V, on top of the states that look like them: their share is
// not evidence of the states.   docs/theory/tracking.md (9.5)
//   I' = I - I_c (I_cc + V^-1)^-1 I_c^T,   g' = g - I_c (I_cc + V^-1)^-1 g_c
bool AllowForCurrents(DriftEvidence& evidence) noexcept {
  const auto V = AsVector(evidence.current_variance_A2);
  if (!(V.array() > 0).all()) return true;  // currents are exact
  auto I = AsMatrix<kStates>(evidence.information);
  auto g = AsVector(evidence.gradient);
  Matrix<kCurrents> S = I.topLeftCorner<kCurrents, kCurrents>();
  S.diagonal() += V.cwiseInverse();
  if (!InvertPositive<kCurrents>(S.data(), kCurrents)) return false;
  const Matrix<kStates, kCurrents> share = I.leftCols<kCurrents>() * S;
  const Matrix<kCurrents, kStates> I_c = I.topRows<kCurrents>();
  const Matrix<kCurrents, 1> g_c = g.head<kCurrents>();
  I -= share * I_c;
  g -= share * g_c;
  return true;
}

// What evidence says of kKept states from the first on alone, the others eliminated, each known to its own variance:
//   I' = I_kk - I_ko (I_oo + D^-1)^-1 I_ok,   g' = g_k - I_ko (I_oo + D^-1)^-1 g_o
template <int kFirst, int kKept>
bool Reduce(const DriftEvidence& evidence, const DriftState& drift, Matrix<kKept>& information,
            Matrix<kKept, 1>& gradient) noexcept {
  constexpr int kOthers = kStates - kKept;
  constexpr auto others = [] {
    std::array<int, kOthers> list{};
    for (int n = 0; n < kOthers; ++n) list[static_cast<std::size_t>(n)] = n < kFirst ? n : n + kKept;
    return list;
  }();
  const auto I = AsMatrix<kStates>(evidence.information);
  const auto g = AsVector(evidence.gradient);
  Matrix<kOthers> S = I(others, others);
  S.diagonal() += AsMatrix<kStates>(drift.covariance).diagonal()(others).cwiseInverse();
  if (!InvertPositive<kOthers>(S.data(), kOthers)) return false;
  const Matrix<kOthers, kKept> I_ok = I.middleCols<kKept>(kFirst)(others, Eigen::all);
  const Matrix<kOthers, 1> g_o = g(others);
  const Matrix<kKept, kOthers> share = I_ok.transpose() * S;
  information = I.block<kKept, kKept>(kFirst, kFirst) - share * I_ok;
  gradient = g.segment<kKept>(kFirst) - share * g_o;
  return true;
}

AmbientEvidence OfAmbient(const DriftEvidence& evidence, const DriftState& drift) noexcept {
  AmbientEvidence ambient;
  Matrix<3> information;
  Matrix<3, 1> gradient;
  ambient.valid = Reduce<kAmbient, 3>(evidence, drift, information, gradient);
  if (!ambient.valid) return ambient;
  AsMatrix<3>(ambient.information) = information;
  AsVector(ambient.gradient) = gradient;
  return ambient;
}

// Removes row and column `state` but for its variance.
void Isolate(int state, double variance, DriftMatrix& covariance) noexcept {
  auto P = AsMatrix<kStates>(covariance);
  P.row(state).setZero();
  P.col(state).setZero();
  P(state, state) = variance;
}

// Squared innovation over the expected one, mean of three components: with nu = I^-1 g the field's innovation,
//   nu^T (I^-1 + P)^-1 nu / 3 = g^T (I + I P I)^-1 g / 3
double Innovation(const AmbientEvidence& evidence, const DriftState& drift) noexcept {
  const auto I = AsMatrix<3>(evidence.information);
  const auto g = AsVector(evidence.gradient);
  const Matrix<3> P = AsMatrix<kStates>(drift.covariance).block<3, 3>(kAmbient, kAmbient);
  Matrix<3> S = I + I * P * I;
  if (!InvertPositive<3>(S.data(), 3)) return 0;
  const double square = g.dot(S * g);
  return std::isfinite(square) ? square / 3 : 0;
}

// A jump opens the field. Correlated innovations mean that it moves: their mean would be small otherwise. The model's
// own error, which lasts too, is allowed for.
void LearnWander(const DriftNoise& noise, const AmbientEvidence& now, double systematic_share,
                 DriftState& drift) noexcept {
  if (!now.valid) return;
  if (Innovation(now, drift) > kJump) return OpenAmbient(noise, drift);
  auto information = AsMatrix<3>(drift.recent_information);
  auto gradient = AsVector(drift.recent_gradient);
  information += kMemory * (AsMatrix<3>(now.information) - information);
  gradient += kMemory * (AsVector(now.gradient) - gradient);
  const AmbientEvidence recent{true, drift.recent_information, drift.recent_gradient};
  const double lasting = Innovation(recent, drift) / (kMoves + kModelLasts * systematic_share);
  double& wander = drift.ambient_wander_T2_s;
  if (lasting > 1) {
    wander = std::clamp(kWanderGrows * wander, 2 * noise.ambient_wander_min_T2_s, noise.ambient_wander_max_T2_s);
  } else if (lasting < 0.5) {
    wander *= kWanderShrinks;
    if (wander < noise.ambient_wander_min_T2_s) wander = 0;
  }
}

double AmbientVariance(const DriftState& drift, int axis) noexcept {
  return AsMatrix<kStates>(drift.covariance)(kAmbient + axis, kAmbient + axis);
}

double WorstAmbientVariance(const DriftState& drift) noexcept {
  return std::max({AmbientVariance(drift, 0), AmbientVariance(drift, 1), AmbientVariance(drift, 2)});
}

bool IsAmbientOpen(const DriftNoise& noise, const DriftState& drift) noexcept {
  return WorstAmbientVariance(drift) > Square(noise.ambient_open_T);
}

void SetAmbientVariance(double variance_T2, DriftMatrix& covariance) noexcept {
  for (int a = kAmbient; a < kAmbient + 3; ++a) Isolate(a, variance_T2, covariance);
}

void SetAmbientVariance(double variance_T2, DriftState& drift) noexcept {
  SetAmbientVariance(variance_T2, drift.covariance);
  drift.recent_information = {};
  drift.recent_gradient = {};
}

}  // namespace

// A play operator: x is dragged behind the core's moment m like a stone on a string,   x <- d min(1, k / |d|),   d = x
// - dm        (9.4)
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

//   1 / n = step (|v| / length + |du/dt| / angle + 1 / time)      docs/theory/tracking.md (9.6)
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
    for (std::size_t c = 0; c < 3; ++c) offsets.ambient_variance_T2[c] = AmbientVariance(drift, static_cast<int>(c));
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
  auto P = AsMatrix<kStates>(drift.covariance);
  auto x = AsVector(drift.mean);
  const StateVector column = P.col(kMoment);
  const double expected = column[kMoment] + variance;
  if (!(expected > 0)) return;
  x += column * ((relative - x[kMoment]) / expected);
  P -= column * column.transpose() / expected;
  drift.still = {};
}

void HoldMoment(double relative, DriftState& drift) noexcept {
  drift.moment_of_pen = relative;
  drift.moment_open = false;
}

MomentEvidence OfMoment(DriftEvidence evidence, const DriftState& drift) noexcept {
  Matrix<1> information;
  Matrix<1> gradient;
  if (!evidence.valid || !AllowForCurrents(evidence)) return {};
  if (!Reduce<kMoment, 1>(evidence, drift, information, gradient)) return {};
  const bool usable = information[0] > 0 && std::isfinite(information[0] + gradient[0]);
  return {usable, information[0], gradient[0]};
}

std::array<double, 3> AmbientField_T(const DriftState& drift) noexcept {
  return {drift.mean[kAmbient], drift.mean[kAmbient + 1], drift.mean[kAmbient + 2]};
}

// x <- phi x (but the ambient field stays where it is), P <- phi P phi + (1 - phi^2) P0 with phi = exp(-dt / tau)
// [Ornstein & Uhlenbeck 1930]; the covariance of changes grows as P does, but slower where one pose carries little
// information.
void PredictDrift(const DriftNoise& noise, std::int64_t t_ns, const PenPlace* pen, DriftState& drift) noexcept {
  const double dt_s = std::clamp(base::Elapsed_s(t_ns, drift.t_ns), 0.0, kForgetMax_s);
  drift.t_ns = t_ns;
  const auto keep_of = [&](double times) { return drift.valid ? std::exp(-times) : 0.0; };
  const double remanence = keep_of(ForgottenOf(noise.still, dt_s, pen, noise.core_kept_A, drift.still));
  const double ambient = keep_of(dt_s / noise.ambient_s), moment = keep_of(dt_s / noise.moment_s);
  StateVector keep;
  keep << remanence, remanence, remanence, ambient, ambient, ambient, moment;
  const bool follows = drift.valid && drift.core_followed;
  auto x = AsVector(drift.mean);
  auto P = AsMatrix<kStates>(drift.covariance);
  if (!follows) x.head<kCurrents>().array() *= keep.head<kCurrents>().array();
  x[kMoment] = drift.moment_of_pen + keep[kMoment] * (x[kMoment] - drift.moment_of_pen);
  StateVector grows;
  for (int a = 0; a < kStates; ++a) grows[a] = (1 - Square(keep[a])) * VarianceOf(noise, follows, a);
  grows.segment<3>(kAmbient).array() += dt_s * drift.ambient_wander_T2_s;
  P = keep.asDiagonal() * P * keep.asDiagonal();
  P.diagonal() += grows;
  grows.tail<kStates - kCurrents>() *= noise.still_grows;
  AsMatrix<kStates>(drift.still.covariance).diagonal() += grows;
  drift.step_s = dt_s;
  drift.valid = true;
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
  ReduceToChange(noise.still, drift.covariance, drift.still, evidence);
  const AmbientEvidence ambient = OfAmbient(evidence, drift);
  LearnWander(noise, ambient, evidence.systematic_share, drift);
  DriftMatrix& covariance = drift.still.referenced ? drift.still.covariance : drift.covariance;
  StateMatrix P = AsMatrix<kStates>(covariance);
  if (!InvertPositive<kStates>(P.data(), kStates)) return {};
  P += evidence.share * AsMatrix<kStates>(evidence.information);
  if (!InvertPositive<kStates>(P.data(), kStates)) return {};
  StateVector x = AsVector(drift.mean) + P * (evidence.share * AsVector(evidence.gradient));
  if (!x.allFinite()) return {};
  if (!drift.moment_open) {
    x[kMoment] = std::clamp(x[kMoment], drift.moment_of_pen - noise.moment_max, drift.moment_of_pen + noise.moment_max);
  }
  AsVector(drift.mean) = x;
  AsMatrix<kStates>(covariance) = P;
  if (drift.still.referenced) {
    AsMatrix<kStates>(drift.covariance) = AsMatrix<kStates>(drift.still.reference_covariance) + P;
  }
  return ambient;
}

}  // namespace omni::tracker
