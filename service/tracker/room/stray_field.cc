#include "service/tracker/room/stray_field.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/tracker/kernel/cholesky.h"
#include "service/tracker/kernel/matrices.h"

namespace omni::tracker {
namespace {

using ReadingVector = Matrix<kReadings, 1>;

void SetGain(const StrayScan& scan, StrayField& stray) noexcept {
  AsRows(stray.gain) = AsRows(scan.gain).topRows<kParameters>() * AsVector(scan.inverse_sigma).asDiagonal();
}

void SetVariance(StrayField& stray) noexcept {
  AsVector(stray.variance_T2) = AsMatrix<kReadings>(stray.covariance_T2).diagonal();
}

void Widen(const Model& model, double share, StrayField& stray) noexcept {
  AsVector(stray.covariance_T2) += share * AsVector(model.stray.covariance_T2);
  SetVariance(stray);
  stray.widened += share;
}

// Of the prior's mean variance.
double ShareOfPrior(const Model& model, double sum_T2) noexcept {
  return sum_T2 / AsMatrix<kReadings>(model.stray.covariance_T2).trace();
}

// gain P gain^T; while x is not accepted: the error of a pose if it is there, gain x x^T gain^T.
void SetPoseCovariance(const StrayOptions& options, StrayField& stray) noexcept {
  const auto gain = AsRows(stray.gain);
  Matrix<kParameters> covariance = Matrix<kParameters>::Zero();
  if (stray.believed) {
    const double factor = stray.places < options.places_min ? options.few_places_factor : 1;
    covariance = factor * (gain * AsMatrix<kReadings>(stray.covariance_T2)) * gain.transpose();
  } else if (!(stray.chi2 < options.nothing_chi2)) {
    const Matrix<kParameters, 1> shift = gain * AsVector(stray.mean_T);
    covariance = shift * shift.transpose();
  }
  AsMatrix<3>(stray.position_covariance_m2) = covariance.topLeftCorner<3, 3>();
  stray.axis_variance = 0.5 * (covariance(3, 3) + covariance(4, 4));
}

// m^T P^-1 m
double Chi2OfMean(const StrayField& stray) noexcept {
  const auto mean_T = AsVector(stray.mean_T);
  return mean_T.dot(AsMatrix<kReadings>(stray.inverse_1_T2) * mean_T);
}

void Forget(StrayField& stray) noexcept {
  stray.cycle = {};
  stray.share = stray.repeats = stray.systematic = 0;
  stray.scan = 0;
}

// x' = x + P' g,  P' = (P^-1 + I)^-1: Kalman's correction in information form, in which E(g^T P' g) = tr(P I) when P is
// right. A larger innovation means that x moves. A far larger one: P was too small, and x stays as it is until P has
// grown.
void Correct(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  const double share = stray.share / stray.cycle.scans;
  const auto information_1_T2 = AsMatrix<kReadings>(stray.cycle.information_1_T2);
  const ReadingVector gradient_1_T =
      share * (AsVector(stray.cycle.gradient_1_T) - information_1_T2 * AsVector(stray.mean_T));
  const double expected = share * AsMatrix<kReadings>(stray.covariance_T2).cwiseProduct(information_1_T2).sum();
  ReadingMatrix P;
  AsMatrix<kReadings>(P) = AsMatrix<kReadings>(stray.inverse_1_T2) + share * information_1_T2;
  if (!InvertPositive<kReadings>(P.data(), kReadings)) return;
  const ReadingVector step_T = AsMatrix<kReadings>(P) * gradient_1_T;
  const double surprise = step_T.dot(gradient_1_T);
  if (!std::isfinite(surprise)) return;
  if (surprise > options.jumps * expected) {
    const double ratio = std::min(surprise / (options.moves * expected), options.jumps_max);
    Widen(model, (ratio - 1) * ShareOfPrior(model, AsVector(stray.variance_T2).sum()), stray);
  } else {
    AsVector(stray.mean_T) += step_T;
    stray.covariance_T2 = P;
  }
  if (surprise > options.moves * expected) stray.wander_1_s *= options.wander_grows;
  if (surprise < options.steady * expected) stray.wander_1_s *= options.wander_shrinks;
  stray.wander_1_s = std::clamp(stray.wander_1_s, options.wander_min_1_s, options.wander_max_1_s);
}

// The uncertainty has been at least as large as what was found: readings hide as much as they show.
void Renew(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  Correct(options, model, stray);
  const double wandered = stray.wander_1_s * options.cycle_scans * base::kTickPeriod_s;
  const double found = ShareOfPrior(model, AsVector(stray.mean_T).squaredNorm());
  Widen(model, std::max(wandered, found - stray.widened), stray);
  SetPoseCovariance(options, stray);
}

bool IsAtNewPlace(const StrayOptions& options, const Pose& pose, StrayField& stray) noexcept {
  if ((pose.position_base_m - base::ToEigen(stray.place_base_m)).norm() <= options.place_m) return false;
  stray.place_base_m = base::FromEigen(pose.position_base_m);
  return true;
}

double SystematicShare(const Measurement& measurement) noexcept {
  return std::clamp(measurement.systematic_share, 0.0, 1.0);
}

// False: its field is larger than any room has, and is dropped.
bool TakeDipole(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  ReadingLanes mean_T;
  ReadingMatrix covariance_T2;
  OffsetsOfDipole(options.dipole, model, stray.dipole, mean_T, covariance_T2);
  if (!(RootMeanSquare(mean_T) <= options.max_T)) {
    stray.dipole = {};
    return false;
  }
  stray.mean_T = mean_T;
  stray.covariance_T2 = covariance_T2;
  SetVariance(stray);
  stray.believed = true;
  stray.places = options.places_min;
  SetPoseCovariance(options, stray);
  return true;
}

void JudgeCycle(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  const double scans = stray.cycle.scans, systematic = stray.systematic / scans;
  JudgeDipole(options.dipole, model, stray.cycle, stray.repeats / scans, systematic, stray.dipole);
}

// The last result is where offsets begin if it is no longer a dipole.
void Follow(const StrayOptions& options, const Model& model, const Measurement& measurement, const StrayScan& scan,
            double repeats, StrayField& stray) noexcept {
  const double systematic = SystematicShare(measurement);
  FollowDipole(options.dipole, model, scan, repeats, systematic, options.every_scans * base::kTickPeriod_s,
               stray.dipole);
  SetGain(scan, stray);
  if (stray.dipole.followed() != nullptr && TakeDipole(options, model, stray)) {
    stray.nothing_cycles = RootMeanSquare(stray.mean_T) < options.something_T ? stray.nothing_cycles + 1 : 0;
    return;
  }
  stray.places = 0;
  stray.widened = ShareOfPrior(model, AsVector(stray.mean_T).squaredNorm());
  Widen(model, options.lost, stray);
  SetPoseCovariance(options, stray);
  Forget(stray);
}

}  // namespace

void StartStray(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  stray = {};
  stray.on = true;
  stray.wander_1_s = options.wander_start_1_s;
  Widen(model, options.start, stray);
}

bool StartFromDipole(const StrayOptions& options, const Model& model, const StrayDipole& dipole,
                     StrayField& stray) noexcept {
  StartStray(options, model, stray);
  stray.dipole = dipole;
  stray.places_to_prove = options.places_min;
  return TakeDipole(options, model, stray);
}

void LoosenStray(const StrayOptions& options, const Model& model, StrayField& stray) noexcept {
  stray.places = 0;
  if (ShareOfPrior(model, AsVector(stray.variance_T2).sum()) < 1) Widen(model, options.lost, stray);
  SetPoseCovariance(options, stray);
  Forget(stray);
}

void LearnStray(const StrayOptions& options, const Model& model, const DriftState& drift,
                const base::HallScan& readings, const Measurement& measurement, const Pose& pose, double repeats,
                StrayField& stray) noexcept {
  // The search and the two inversions take turns with the scans that are gathered.
  const int number = ++stray.scan;
  if (stray.dipole.followed() != nullptr || number < options.cycle_scans - 1) {
    const int turn = number % options.every_scans;
    if (turn == 3 && stray.dipole.followed() == nullptr && options.dipole.enabled)
      SearchDipole(options.dipole, model, stray.dipole);
    if (turn != 1) return;
    StrayScan scan;
    const ReadingLanes* variance_T2 = stray.believed ? &stray.variance_T2 : nullptr;
    if (!MakeStrayScan(model, drift, measurement, pose, stray.mean_T, variance_T2, scan)) return;
    if (stray.dipole.followed() != nullptr) {
      Follow(options, model, measurement, scan, repeats, stray);
      const FollowedDipole* magnet = stray.dipole.followed();
      const bool proves = magnet != nullptr && stray.places_to_prove > 0 && magnet->misfit <= options.proves;
      if (proves && IsAtNewPlace(options, pose, stray)) --stray.places_to_prove;
      if (stray.nothing_cycles >= options.nothing_cycles) stray = {};
      return;
    }
    AddScan(scan, readings, stray.mean_T, stray.cycle);
    const double systematic = SystematicShare(measurement);
    stray.share += EvidenceShare(repeats, systematic);
    stray.repeats += repeats;
    stray.systematic += systematic;
    SetGain(scan, stray);
    return;
  }
  if (number < options.cycle_scans) {
    stray.inverse_1_T2 = stray.covariance_T2;
    stray.inverted = InvertPositive<kReadings>(stray.inverse_1_T2.data(), kReadings);
    stray.chi2 = stray.inverted ? Chi2OfMean(stray) : 0;
    stray.believed =
        stray.believed || (stray.chi2 > options.something_chi2 && RootMeanSquare(stray.mean_T) > options.something_T);
    stray.nothing_cycles = stray.chi2 < options.nothing_chi2 ? stray.nothing_cycles + 1 : 0;
    return;
  }
  if (IsAtNewPlace(options, pose, stray)) ++stray.places;
  if (stray.inverted && stray.cycle.scans > 0) {
    JudgeCycle(options, model, stray);
    if (stray.dipole.followed() == nullptr || !TakeDipole(options, model, stray)) Renew(options, model, stray);
  }
  Forget(stray);
  if (stray.nothing_cycles >= options.nothing_cycles) stray = {};
}

void AddStrayCovariance(const StrayOptions& options, const StrayField& stray, Fit& fit) noexcept {
  fit.covariance.topLeftCorner<3, 3>() += AsMatrix<3>(stray.position_covariance_m2);
  fit.covariance(3, 3) += stray.axis_variance;
  fit.covariance(4, 4) += stray.axis_variance;
  if (stray.places_to_prove > 0) fit.covariance *= options.unproven_factor;
}

}  // namespace omni::tracker
