#include "service/tracker/stages/scan_context.h"

#include <algorithm>

#include "service/tracker/kernel/steel.h"
#include "service/tracker/solve/solver.h"
#include "service/tracker/solve/static_solve.h"

namespace omni::tracker {

bool LearnsDrift(const Config& config) noexcept {
  return config.drift.enabled && config.drift.remanence_A > 0 && !config.trust.currents_hidden;
}

Measurement MeasureScan(const ScanContext& context, const DriftState& drift, const Doubt& doubt) noexcept {
  Offsets offsets = drift.valid ? OffsetsOf(context.config.drift, drift) : Offsets{};
  offsets.local_base_T = context.local;
  offsets.mains = context.mains;
  if (context.stray != nullptr && context.stray->believed) {
    offsets.reading_T = &context.stray->mean_T;
    offsets.reading_variance_T2 = &context.stray->variance_T2;
  }
  Trust trust = TrustIn(doubt, context.config.trust);
  if (context.stray != nullptr && context.stray->on) {
    trust.model_error_relative = std::max(trust.model_error_relative, context.config.stray.model_error);
  }
  Measurement measurement =
      MakeMeasurement(context.config.model, trust, context.scan, context.before, context.now, offsets);
  measurement.moment_scale = MomentScale(drift);
  return measurement;
}

int DegreesOfFreedom(const Measurement& measurement) noexcept {
  return measurement.axes - measurement.fixed - kParameters - (measurement.nuisances > base::kCoilCount ? 3 : 0);
}

bool HasMagnet(const Config& config, const Measurement& measurement) noexcept {
  return measurement.axes >= config.axes_min && measurement.field_rms_T >= config.field_min_T;
}

double PositionVariance(const Fit& fit) noexcept { return fit.covariance.topLeftCorner<3, 3>().trace(); }

bool FitsReadings(const Config& config, const Measurement& measurement, const Fit& fit) noexcept {
  const int dof = DegreesOfFreedom(measurement);
  return fit.converged && dof >= config.dof_min && fit.chi2 <= ChiSquareGate(config.chi2_max, dof);
}

bool IsInReach(const Config& config, const Pose& pose) noexcept {
  const double r = pose.position_base_m.norm();
  return r >= config.reach_min_m && r <= config.reach_max_m && pose.position_base_m.z() >= config.z_min_m;
}

Precision PrecisionOf(const Config& config) noexcept {
  return config.trust.currents_hidden ? Precision::kDouble : config.precision;
}

Fit SolveCold(const Config& config, const Measurement& measurement, const Pose& start) noexcept {
  return SolvePose(
      config.model, measurement, start,
      {.precision = PrecisionOf(config), .iterations_max = config.cold_iterations_max, .damping = kColdDamping});
}

Outcome FitWarm(const Config& config, const FilterState& predicted, KernelSums* sums,
                Measurement& measurement) noexcept {
  const Eigen::Vector3d u = base::ToEigen(predicted.axis_base);
  const Eigen::Vector3d u_rate = base::ToEigen(predicted.angular_velocity_base_rad_s).cross(u);
  const base::Vec3& v = predicted.velocity_base_m_s;
  measurement.velocity_base_m_s = {v.x, v.y, v.z};
  measurement.axis_rate_base_1_s = {u_rate.x(), u_rate.y(), u_rate.z()};
  Outcome outcome{
      .fit = SolvePose(config.model, measurement, {base::ToEigen(predicted.position_base_m), u},
                       {.precision = PrecisionOf(config), .iterations_max = config.iterations_max, .sums = sums})};
  outcome.explained = FitsReadings(config, measurement, outcome.fit);
  outcome.good = outcome.explained && IsInReach(config, outcome.fit.pose);
  return outcome;
}

Outcome FitCold(const ScanContext& context, const DriftState& drift, const Doubt& doubt,
                Measurement& measurement) noexcept {
  const Config& config = context.config;
  measurement.velocity_base_m_s = {};
  measurement.axis_rate_base_1_s = {};
  Outcome outcome;
  outcome.cold = true;
  const ColdCandidates candidates = RankGrid(config.model, measurement);
  for (std::size_t c = 0; c < static_cast<std::size_t>(candidates.count); ++c) {
    const int spent = outcome.fit.iterations;
    outcome.fit = SolveCold(config, measurement, candidates.poses[c]);
    if (HasSteel(config.model) && outcome.fit.pose.position_base_m.allFinite()) {
      const int first = outcome.fit.iterations;
      const Pose expected = outcome.fit.pose;
      const SteelResponse steel = SteelResponseOf(config.model, expected, MomentScale(drift));
      measurement =
          MeasureScan({config, context.scan, context.before, context.now, &steel.field_T, context.stray, context.mains},
                      drift, doubt);
      outcome.fit = SolveCold(config, measurement, expected);
      CorrectForSteel(config.model, measurement, expected, steel, outcome.fit);
      outcome.fit.iterations += first;
    }
    outcome.fit.iterations += spent;
    const bool fits = FitsReadings(config, measurement, outcome.fit);
    outcome.explained = outcome.explained || fits;
    outcome.good = fits && IsInReach(config, outcome.fit.pose);
    // Far below or beyond the base the readings show little: only a fit well outside decides.
    if (outcome.good || (fits && outcome.fit.pose.position_base_m.norm() > config.reach_max_m)) break;
  }
  return outcome;
}

double Chi2Under(const ScanContext& context, const FilterState& predicted, const DriftState& drift, const Doubt& doubt,
                 double no_fit) noexcept {
  Measurement measurement = MeasureScan(context, drift, doubt);
  return Chi2Of(FitWarm(context.config, predicted, nullptr, measurement), no_fit);
}

void TrySensor(const ScanContext& context, const FilterState& predicted, const DriftState& drift, bool failing,
               double chi2, Doubt& doubt) noexcept {
  Doubt without = doubt;
  without.left_out = NextTrial(failing, doubt);
  AddTrial(std::max(0.0, chi2 - Chi2Under(context, predicted, drift, without, chi2)), doubt);
}

}  // namespace omni::tracker
