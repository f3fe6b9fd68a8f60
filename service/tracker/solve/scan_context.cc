#include "service/tracker/solve/scan_context.h"

#include <algorithm>

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

}  // namespace omni::tracker
