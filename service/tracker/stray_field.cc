#include "service/tracker/stray_field.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/tracker/cholesky.h"

namespace omni::tracker {
namespace {

constexpr std::size_t kRows = kReadings;
constexpr std::size_t kCoils = base::kCoilCount;
// What is eliminated of each scan: pose, currents, ambient field, moment.
constexpr std::size_t kAmbient = kParameters + kCoils, kMoment = kAmbient + 3;
constexpr std::size_t kEliminated = kMoment + 1;
constexpr double kCurrentMin_A2 = 1e-12, kMomentMin = 1e-8;  // variances of what is known well
constexpr double kWhiteMin = 1e-3;  // of a reading's variance: what is its own, where the stray field is unknown

using Rows = ReadingLanes;

// One scan, linearised at its pose and whitened without the stray field's variance.
struct LinearScan {
  Rows inverse_sigma{}, residual{};
  std::array<Rows, kEliminated> columns{};
};

LinearScan LineariseScan(const Model& model, const Measurement& measurement, const Pose& pose,
                         const StrayField& stray) noexcept {
  LinearScan scan;
  const KernelPose at = ToKernel(MakePosePoint(pose), measurement.velocity_base_m_s, measurement.axis_rate_base_1_s);
  BlockField field;
  ActiveKernel().field(model.places[0], model.tool, at, field);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < kSensors; ++i) {
      const std::size_t row = kSensors * axis + i;
      const double with_stray = measurement.inverse_sigma[axis][i];
      if (with_stray == 0) continue;
      const double unknown_T2 = stray.believed ? stray.variance_T2[row] : 0.0;
      const double raise = 1 / std::sqrt(std::max(kWhiteMin, 1 - unknown_T2 * with_stray * with_stray));
      scan.inverse_sigma[row] = raise * with_stray;
      double tool = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double weight = raise * measurement.weight[3 * axis + c][i];
        const double of_tool = weight * measurement.moment_scale;
        tool += of_tool * field.B_T[c][i];
        for (std::size_t k = 0; k < kParameters; ++k) scan.columns[k][row] += of_tool * field.derivative[k][c][i];
        scan.columns[kAmbient + c][row] = weight;
      }
      for (std::size_t k = 0; k < kCoils; ++k) {
        scan.columns[kParameters + k][row] = scan.inverse_sigma[row] * model.coil_map_T_A[(3 * i + axis) * kCoils + k];
      }
      scan.columns[kMoment][row] = tool;
      scan.residual[row] = tool - raise * measurement.whitened[axis][i];
      if (!stray.believed) scan.residual[row] += scan.inverse_sigma[row] * stray.mean_T[row];
      for (std::size_t k = 0; k < kParameters; ++k) {
        scan.residual[row] -= measurement.age_s[i] * at.rate_1_s[k] * scan.columns[k][row];
      }
    }
  }
  return scan;
}

// (A^T A + prior)^-1 A^T, a row for each unknown that is eliminated. No prior of pose and ambient field: what is known
// of that field was learnt with the stray field taken for known.
bool Eliminator(const Measurement& measurement, const DriftState& drift, const LinearScan& scan,
                std::array<Rows, kEliminated>& result) noexcept {
  std::array<double, kEliminated * kEliminated> H;
  for (std::size_t a = 0; a < kEliminated; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = 0;
      for (std::size_t row = 0; row < kRows; ++row) sum += scan.columns[a][row] * scan.columns[b][row];
      H[a * kEliminated + b] = H[b * kEliminated + a] = sum;
    }
  }
  const auto drift_variance = [&](std::size_t state) { return drift.covariance[state * (kDriftStates + 1)]; };
  for (std::size_t k = 0; k < kCoils; ++k) {
    const double variance_A2 = measurement.current_variance_A2[k] + drift_variance(k);
    H[(kParameters + k) * (kEliminated + 1)] += 1 / std::max(variance_A2, kCurrentMin_A2);
  }
  H[kMoment * (kEliminated + 1)] += 1 / std::max(drift_variance(kNuisancesMax), kMomentMin);
  SmallCholesky<kEliminated> factors;
  if (!factors.Factor(H.data(), kEliminated, 0)) return false;
  result = scan.columns;
  factors.SolveSides(result);
  return true;
}

// With A, r of the linear scan, D = diag(1 / sigma):
//   I += share D P D,   g -= share D P r,   P = 1 - A (A^T A + prior)^-1 A^T
void Gather(const Model& model, const DriftState& drift, const Measurement& measurement, const Pose& pose, double share,
            StrayField& stray) noexcept {
  const LinearScan scan = LineariseScan(model, measurement, pose, stray);
  std::array<Rows, kEliminated> gain;
  if (!Eliminator(measurement, drift, scan, gain)) return;
  Rows rest = scan.residual;
  for (std::size_t e = 0; e < kEliminated; ++e) {
    double size = 0;
    for (std::size_t a = 0; a < kRows; ++a) size += gain[e][a] * scan.residual[a];
    for (std::size_t a = 0; a < kRows; ++a) rest[a] -= scan.columns[e][a] * size;
  }
  for (Rows& row : gain) {
    for (std::size_t a = 0; a < kRows; ++a) row[a] *= scan.inverse_sigma[a];
  }
  for (std::size_t a = 0; a < kRows; ++a) {
    const double weight = share * scan.inverse_sigma[a];
    Rows eliminated{};
    for (std::size_t e = 0; e < kEliminated; ++e) {
      const double factor = weight * scan.columns[e][a];
      for (std::size_t b = 0; b < kRows; ++b) eliminated[b] += factor * gain[e][b];
    }
    double* row = &stray.information_1_T2[a * kRows];
    for (std::size_t b = 0; b < kRows; ++b) row[b] -= eliminated[b];
    row[a] += weight * scan.inverse_sigma[a];
    stray.gradient_1_T[a] -= weight * rest[a];
  }
  std::copy_n(gain.begin(), kParameters, stray.gain.begin());
}

void Widen(const Model& model, double share, StrayField& stray) noexcept {
  for (std::size_t e = 0; e < stray.covariance_T2.size(); ++e) {
    stray.covariance_T2[e] += share * model.stray.covariance_T2[e];
  }
  for (std::size_t a = 0; a < kRows; ++a) stray.variance_T2[a] = stray.covariance_T2[a * (kRows + 1)];
  stray.widened += share;
}

// Of the prior's mean variance.
double ShareOfPrior(const Model& model, double sum_T2) noexcept {
  double prior_T2 = 0;
  for (std::size_t a = 0; a < kRows; ++a) prior_T2 += model.stray.covariance_T2[a * (kRows + 1)];
  return sum_T2 / prior_T2;
}
double Sum(const Rows& values) noexcept {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}
double SquareSum(const Rows& values) noexcept {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

// gain P gain^T
void SetPoseCovariance(const StrayOptions& options, StrayField& stray) noexcept {
  std::array<Rows, kParameters> covered{};
  for (std::size_t k = 0; k < kParameters; ++k) {
    for (std::size_t a = 0; a < kRows; ++a) {
      const double factor = stray.gain[k][a];
      for (std::size_t b = 0; b < kRows; ++b) covered[k][b] += factor * stray.covariance_T2[a * kRows + b];
    }
  }
  const double factor = stray.places < options.places_min ? options.few_places_factor : 1;
  const auto covariance = [&](std::size_t k, std::size_t j) {
    double sum = 0;
    for (std::size_t a = 0; a < kRows; ++a) sum += covered[k][a] * stray.gain[j][a];
    return factor * sum;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t j = 0; j < 3; ++j) stray.position_covariance_m2[3 * k + j] = covariance(k, j);
  }
  stray.axis_variance = 0.5 * (covariance(3, 3) + covariance(4, 4));
}

// m^T P^-1 m
double Chi2OfMean(const StrayField& stray) noexcept {
  double chi2 = 0;
  for (std::size_t a = 0; a < kRows; ++a) {
    for (std::size_t b = 0; b < kRows; ++b) {
      chi2 += stray.mean_T[a] * stray.inverse_1_T2[a * kRows + b] * stray.mean_T[b];
    }
  }
  return chi2;
}

void Forget(StrayField& stray) noexcept {
  stray.information_1_T2 = {};
  stray.gradient_1_T = {};
  stray.scan = 0;
}

// x' = x + P' g,  P' = (P^-1 + I)^-1: Kalman's correction in information form, in which E(g^T P' g) = tr(P I) when P is
// right. More surprise than that: x moves. Far more: P was too small, and x stays as it is until P has grown.
void Correct(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  ReadingMatrix P;
  double expected = 0, surprise = 0;
  for (std::size_t e = 0; e < P.size(); ++e) {
    expected += stray.covariance_T2[e] * stray.information_1_T2[e];
    P[e] = stray.inverse_1_T2[e] + stray.information_1_T2[e];
  }
  if (!InvertPositive<kReadings>(P.data(), kReadings)) return;
  Rows mean_T = stray.mean_T;
  for (std::size_t a = 0; a < kRows; ++a) {
    double step_T = 0;
    for (std::size_t b = 0; b < kRows; ++b) step_T += P[a * kRows + b] * stray.gradient_1_T[b];
    mean_T[a] += step_T;
    surprise += step_T * stray.gradient_1_T[a];
  }
  if (!std::isfinite(surprise)) return;
  if (surprise > options.jumps * expected) {
    const double ratio = std::min(surprise / (options.moves * expected), options.jumps_max);
    Widen(model, (ratio - 1) * ShareOfPrior(model, Sum(stray.variance_T2)), stray);
  } else {
    stray.mean_T = mean_T;
    stray.covariance_T2 = P;
  }
  if (surprise > options.moves * expected) stray.wander_1_s *= options.wander_grows;
  if (surprise < options.steady * expected) stray.wander_1_s *= options.wander_shrinks;
  stray.wander_1_s = std::clamp(stray.wander_1_s, options.wander_min_1_s, options.wander_max_1_s);
}

// What was found is as large as what is unknown was once, at the least: what readings hide is as large as what they
// show.
void Renew(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  Correct(options, model, stray);
  const double wandered = stray.wander_1_s * options.cycle_scans * base::kTickPeriod_s;
  const double found = ShareOfPrior(model, SquareSum(stray.mean_T));
  Widen(model, std::max(wandered, found - stray.widened), stray);
  if (stray.wander_1_s > options.moving_1_s) stray.places = 0;
  SetPoseCovariance(options, stray);
}

}  // namespace

void StartStray(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  stray = {};
  stray.on = true;
  stray.wander_1_s = options.wander_start_1_s;
  Widen(model, options.start, stray);
}

void LoosenStray(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  stray.places = 0;
  if (ShareOfPrior(model, Sum(stray.variance_T2)) < options.lost_max) Widen(model, options.lost, stray);
  SetPoseCovariance(options, stray);
  Forget(stray);
}

void LearnStray(const StrayOptions& options, const Model& model, const DriftState& drift,
                const Measurement& measurement, const Pose& pose, double share, StrayField& stray) noexcept {
  // The two inversions take turns with the scans that are gathered.
  const int scan = ++stray.scan;
  if (scan < options.cycle_scans - 1) {
    if (scan % options.every_scans == 1) Gather(model, drift, measurement, pose, share, stray);
    return;
  }
  if (scan < options.cycle_scans) {
    stray.inverse_1_T2 = stray.covariance_T2;
    stray.inverted = InvertPositive<kReadings>(stray.inverse_1_T2.data(), kReadings);
    const double chi2 = stray.inverted ? Chi2OfMean(stray) : 0;
    const double size_T = std::sqrt(SquareSum(stray.mean_T) / kRows);
    stray.believed = stray.believed || (chi2 > options.something_chi2 && size_T > options.something_T);
    stray.nothing_cycles = chi2 < options.nothing_chi2 ? stray.nothing_cycles + 1 : 0;
    return;
  }
  if ((pose.position_base_m - base::ToEigen(stray.place_base_m)).norm() > options.place_m) {
    stray.place_base_m = base::FromEigen(pose.position_base_m);
    ++stray.places;
  }
  if (stray.inverted) Renew(options, model, stray);
  Forget(stray);
  if (stray.nothing_cycles >= options.nothing_cycles) stray = {};
}

void AddStrayCovariance(const StrayField& stray, Fit& fit) noexcept {
  using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  fit.covariance.topLeftCorner<3, 3>() += Eigen::Map<const RowMajor3>(stray.position_covariance_m2.data());
  fit.covariance(3, 3) += stray.axis_variance;
  fit.covariance(4, 4) += stray.axis_variance;
}

}  // namespace omni::tracker
