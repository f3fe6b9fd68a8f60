#include "service/tracker/tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "service/base/eigen.h"
#include "service/base/stamp.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/kernel/steel.h"
#include "service/tracker/room/findings.h"
#include "service/tracker/room/nuisance.h"
#include "service/tracker/room/point_noise.h"
#include "service/tracker/solve/fit_scan.h"
#include "service/tracker/solve/gap.h"

namespace omni::tracker {
namespace {

using Eigen::Vector3d;

constexpr double kPredictMax_s = 0.020;
constexpr double kCurrentStepMax_A = 1e3;
constexpr double kForgetMax_s = 1e6;
constexpr double kCalibratedError = 0.01;  // of the model: beyond, something other than the calibration is wrong
constexpr double kCalibratedCoils = 6e-4;  // of the coils' field, whose maps were measured
constexpr double kDrawnError = 0.05;       // of an uncalibrated base: 1 mm, 1.5 %, 1.15 degrees
constexpr double kDrawnLowerBelow = 0.6;   // of its chi2 per degree of freedom: at one place it is lower by chance
constexpr double kDrawnPlace_m = 0.03;     // a pen at rest wanders by 10 mm where its place is known poorly
constexpr double kDrawnSigma_m = 0.05;     // in any ambient field a pen that points straight down is known to 20 mm
constexpr double kDrawnSame_rad = 2, kDrawnSame_s = 1e3;
constexpr double kTypicalDistance_m = 0.15;  // from the pen to a sensor
constexpr double kTypicalRadius_m = 0.065;   // from the pen to the core
constexpr double kModelErrorMin = 1e-3;      // of a calibrated base, once its readings have been evaluated

PoseMeasurement ToMeasurement(const Fit& fit) noexcept {
  PoseMeasurement measured{base::FromEigen(fit.pose.position_base_m), base::FromEigen(fit.pose.axis_base), {}};
  using RowMajor5 = Eigen::Matrix<double, kParameters, kParameters, Eigen::RowMajor>;
  Eigen::Map<RowMajor5>(measured.covariance.data()) = fit.covariance;
  return measured;
}

void SetDevicePoint(double tip_offset_m, base::ToolState& tool) noexcept {
  const Vector3d u = base::ToEigen(tool.axis_base);
  const Vector3d u_rate = base::ToEigen(tool.angular_velocity_base_rad_s).cross(u);
  tool.device_point_base_m = base::FromEigen(base::ToEigen(tool.position_base_m) + tip_offset_m * u);
  tool.device_point_velocity_base_m_s = base::FromEigen(base::ToEigen(tool.velocity_base_m_s) + tip_offset_m * u_rate);
}

bool IsFinite(const base::ToolState& tool) noexcept {
  const auto finite = [](const base::Vec3& v) { return std::isfinite(v.x + v.y + v.z); };
  return finite(tool.position_base_m) && finite(tool.axis_base) && finite(tool.velocity_base_m_s) &&
         finite(tool.angular_velocity_base_rad_s) && finite(tool.device_point_velocity_base_m_s);
}

// Adds to a pose's covariance what no scan shows: the calibration's remaining error. Of that, `systematic` (a share of
// the fit's own covariance) is there already, as the model's error.
void AddUnseen(const Model& model, const PoseMeasurement& measured, double systematic,
               std::array<double, 25>& covariance) noexcept {
  const double calibration_m2 = model.expected_error_m * model.expected_error_m / 3;
  const auto add = [&](std::size_t i, double variance) {
    covariance[i] += std::max(0.0, variance - systematic * measured.covariance[i]);
  };
  for (const std::size_t i : {0U, 6U, 12U}) add(i, calibration_m2);
  for (const std::size_t i : {18U, 24U}) add(i, calibration_m2 / (kTypicalRadius_m * kTypicalRadius_m));
}

// Publishes the filter's covariance plus the share of the fit's that no filtering removes.
base::ToolState MakeToolState(const Config& config, const base::HallScan& scan, const PoseMeasurement& measured,
                              double systematic, const FilterState& filter) noexcept {
  const Model& model = config.model;
  base::ToolState tool;
  tool.t_ns = scan.t_ns;
  tool.status = base::TrackingStatus::kTracking;
  tool.ever_tracked = true;
  tool.position_base_m =
      base::FromEigen(base::ToEigen(filter.position_base_m) + Vector3d(model.core_centre_base_m.data()));
  tool.axis_base = filter.axis_base;
  tool.velocity_base_m_s = filter.velocity_base_m_s;
  tool.angular_velocity_base_rad_s = filter.angular_velocity_base_rad_s;
  SetDevicePoint(model.tip_offset_m, tool);
  tool.gap_m = CylinderGap(tool.position_base_m, tool.axis_base, model.magnet_radius_m, model.magnet_half_height_m,
                           model.hull_radius_m);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      const std::size_t e = 3 * row + column;
      tool.covariance[5 * row + column] = filter.covariance_pp[e] + filter.lasting_m2[e];
    }
  }
  for (const std::size_t i : {18U, 24U}) tool.covariance[i] = filter.variance_angle + filter.lasting_rad2;
  AddUnseen(model, measured, systematic, tool.covariance);
  tool.device_point_noise = NoiseOfPoint(filter, model.tip_offset_m);
  tool.device_point_noise_along = NoiseAlong(filter);
  return tool;
}

std::uint32_t LimitsOf(const Config& config, const base::HallScan& scan, const Measurement& measurement,
                       const Outcome& outcome, bool explained, const base::ToolState& tool) noexcept {
  std::uint32_t limits = 0;
  const Vector3d p = base::ToEigen(tool.position_base_m);
  const bool saturated = (scan.saturated_mask & ((1u << kReadings) - 1)) != 0;
  const bool magnet = measurement.axes >= config.axes_min && measurement.field_rms_T >= config.field_min_T;
  if (std::abs(p.dot(base::ToEigen(tool.axis_base))) < config.tilted_cos * p.norm()) limits |= base::kToolTilted;
  if (!(outcome.fit.covariance.topLeftCorner<3, 3>().trace() <= config.coarse_m * config.coarse_m)) {
    limits |= base::kToolCoarse;
  }
  if (measurement.axes <= kReadings / 2) limits |= base::kToolFewReadings;
  if (saturated) limits |= base::kToolSaturated;
  if (!explained && magnet) limits |= base::kToolContradicted;
  return limits;
}

void Describe(const Config& config, const base::HallScan& scan, const Measurement& measurement, const Outcome& outcome,
              bool explained, base::ToolState& tool) noexcept {
  tool.chi2 = std::isfinite(outcome.fit.chi2) ? outcome.fit.chi2 : std::numeric_limits<double>::max();
  tool.dof = std::max(0, measurement.axes - measurement.fixed - kParameters);
  tool.iterations = outcome.fit.iterations;
  tool.field_rms_T = measurement.field_rms_T;
  tool.limits = LimitsOf(config, scan, measurement, outcome, explained, tool);
}

// Holds the last pose while the velocities fade.
void Hold(const Config& config, const base::HallScan& scan, State& state) noexcept {
  base::ToolState& tool = state.published;
  const double dt_s = std::clamp(base::Elapsed_s(scan.t_ns, tool.t_ns), 0.0, 1.0);
  const bool absent = ++state.bad_scans >= config.lost_after_scans || !state.ever_tracked;
  state.bad_scans = std::min(state.bad_scans, config.lost_after_scans);
  const double fade = absent ? 0.0 : std::exp(-dt_s / config.velocity_decay_s);
  tool.t_ns = scan.t_ns;
  tool.status = absent ? base::TrackingStatus::kAbsent : base::TrackingStatus::kLost;
  tool.velocity_base_m_s = fade * tool.velocity_base_m_s;
  tool.angular_velocity_base_rad_s = fade * tool.angular_velocity_base_rad_s;
  tool.device_point_velocity_base_m_s = fade * tool.device_point_velocity_base_m_s;
  if (absent) state.warm = false;
}

// Filter, from its prediction, and publish; false when arithmetic went wrong, which only a hostile scan could cause.
bool Publish(const Config& config, const base::HallScan& scan, const Outcome& outcome, double systematic, double dt_s,
             bool continues, FilterState& filter, State& state) noexcept {
  const PoseMeasurement measured = ToMeasurement(outcome.fit);
  if (continues && !outcome.cold) {
    CorrectFilter(config.filter, measured, dt_s, filter);
  } else {
    ResetFilter(config.filter, measured, filter);
    state.cold_scan = state.scans;
  }
  const base::ToolState tool = MakeToolState(config, scan, measured, systematic, filter);
  if (!IsFinite(tool)) return false;
  state.published = tool;
  state.filter = filter;
  state.filter_t_ns = scan.t_ns;
  state.warm = state.ever_tracked = true;
  state.bad_scans = state.cold_pause = 0;
  state.pair.step = PairStart::Step::kNone;
  return true;
}

// Every few scans all drifting quantities are unknowns.
bool IsWideScan(const Config& config, const State& state) noexcept {
  return LearnsDrift(config) &&
         (state.scans % static_cast<std::uint32_t>(std::max(1, config.drift.every_scans)) == 0 ||
          IsAmbientLively(config.drift, state.drift) || (state.warm && !state.magnet.identified));
}

// No room is like that: a wrong pose is explained by fields that do not exist.
bool IsAbsurd(const Config& config, const State& state) noexcept {
  const auto [x_T, y_T, z_T] = AmbientField_T(state.drift);
  const double size_T = std::hypot(x_T, y_T, z_T);
  const bool no_pen =
      IsToBeIdentified(state.magnet) && std::abs(MomentScale(state.drift) - 1) >= config.magnets.furthest;
  return no_pen || !(size_T <= config.ambient_max_T && RootMeanSquare(state.stray.mean_T) <= config.stray.max_T);
}

// Resets what is known of room and pose; what was found of sensors and calibration stays.
void Restart(State& state) noexcept {
  state.drift = {};
  state.mains = {};
  state.stray = {};
  state.evidence = {};
  state.warm = false;
  ForgetMagnet(state.magnet);
}

void ForgetDrift(const Config& config, const base::HallScan& scan, const PenPlace* pen, DriftState& drift) noexcept {
  std::array<double, base::kCoilCount> step_A{};
  double sum_A = 0;
  for (std::size_t k = 0; k < step_A.size(); ++k) {
    step_A[k] = scan.coil_current_A[k] - drift.coil_current_A[k];
    sum_A += std::abs(step_A[k]);
  }
  if (!(sum_A <= kCurrentStepMax_A)) step_A = {};  // not a current: the scan is not used
  PredictDrift(config.drift, std::clamp(base::Elapsed_s(scan.t_ns, drift.t_ns), 0.0, kForgetMax_s), step_A, pen, drift);
  drift.t_ns = scan.t_ns;
  if (sum_A <= kCurrentStepMax_A) drift.coil_current_A = scan.coil_current_A;
}

PenPlace PlaceOf(const Model& model, double moment_scale, const FilterState& filter) noexcept {
  const auto& variance_m2 = filter.covariance_pp;
  const Vector3d moment_Am2 = moment_scale * model.moment_Am2 * base::ToEigen(filter.axis_base);
  using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Vector3d core_A = Eigen::Map<const RowMajor3d>(model.core_current_A_T.data()) *
                          magnetics::DipoleField(moment_Am2, base::ToEigen(filter.position_base_m));
  return {filter.position_base_m, filter.axis_base, base::FromEigen(core_A),
          std::sqrt(variance_m2[0] + variance_m2[4] + variance_m2[8]), std::sqrt(2 * filter.variance_angle)};
}

void LearnFromLast(const Config& config, State& state) noexcept {
  if (!state.evidence.valid) return;
  const std::array<double, 3> ambient_T = AmbientField_T(state.drift);
  const AmbientEvidence said = CorrectDrift(config.drift, state.evidence, state.drift);
  state.evidence.valid = false;
  if (IsToBeIdentified(state.magnet)) IdentifyMagnet(config.magnets, state.drift, state.magnet);
  if (said.valid && config.mains.enabled) {
    LearnMains(config.mains, said, ambient_T, state.evidence.age_s, state.mains);
  }
}

void Start(const Config& config, const base::HallScan& scan, State& state) noexcept {
  state.doubt.model_error = config.doubt.model_error_start;
  StartAway(config.away, scan.t_ns, state.away);
  StartMagnet(config.magnets, LearnsDrift(config), state.magnet);
  if (LearnsDrift(config)) ForgetDrift(config, scan, nullptr, state.drift);
}

// A scan without a pose, or with one. A magnet nearby that leaves no trace in the remaining field has gone.
void LearnAway(const Config& config, const base::HallScan& scan, bool away, State& state) noexcept {
  if (!away || !config.away.enabled || !LearnsDrift(config)) return EndAwayWindow(state.away);
  if (WatchAway(config.away, config.model, scan, state.drift, state.away)) state.stray = {};
}

// Of a pen whose moment is not known as well as that of the calibrated one.
void AddMomentCovariance(const State& state, Fit& fit) noexcept {
  const double variance = PublishedVariance(state.drift, state.magnet);
  if (!(variance > 0)) return;
  const Eigen::Map<const Eigen::Matrix<double, kParameters, 1>> shift(state.magnet.pose_per_moment.data());
  fit.covariance += variance * shift * shift.transpose();
}

Pose PoseOf(const FilterState& filter) noexcept {
  return {base::ToEigen(filter.position_base_m), base::ToEigen(filter.axis_base)};
}

// No hand carries a pen there within a scan: more likely this scan is wrong and happens to fit. A pen that stays there
// is accepted.
bool IsEarlyJump(const Config& config, const State& state, const FilterState& predicted,
                 const Outcome& outcome) noexcept {
  const Vector3d jump = outcome.fit.pose.position_base_m - base::ToEigen(predicted.position_base_m);
  return state.bad_scans < config.jump_scans && !(jump.norm() <= config.jump_max_m);
}

// A position error dp at the distance d looks like 3 dp / d of a dipole's field; never less than the nominal share,
// which a calibration cannot see in itself (sensors that are not straight).   docs/theory/tracking.md (3)
double ModelErrorOf(const base::Calibration& calibration, double nominal) {
  if (!(calibration.expected_error_m > 0)) return nominal;
  return std::max(nominal, 3 * calibration.expected_error_m / kTypicalDistance_m);
}

}  // namespace

Config MakeConfig(const base::Calibration& calibration) {
  Config config;
  config.model = MakeModel(calibration);
  if (!SteelMatters(config.model)) config.model.steel.strength = 0;
  config.trust.coil_error_relative = kCalibratedCoils;
  config.trust.model_error_relative = kModelErrorMin;
  config.doubt.model_error_start = std::min(ModelErrorOf(calibration, Trust{}.model_error_relative), kDrawnError);
  config.drift.core_kept_A = calibration.core_kept_A;
  config.doubt.model_error_max = std::max(kCalibratedError, config.doubt.model_error_start);
  return config;
}

// Nominal geometry: the readings show how accurately it is built.
Config MakeConfig(const base::DeviceGeometry& device) {
  Config config = MakeConfig(magnetics::NominalCalibration(device));
  config.trust = Trust{};
  config.doubt.model_error_max = config.doubt.cold_error_max = kDrawnError;
  config.doubt.lower_below = kDrawnLowerBelow;
  config.doubt.cold_sigma_max_m = kDrawnSigma_m;
  config.doubt.place_m = kDrawnPlace_m;
  // A sensor that is turned or out of place has the same error over most of the reach, for as long as it is there.
  config.drift.same_error_m = kTypicalDistance_m;
  config.drift.same_error_rad = kDrawnSame_rad;
  config.drift.same_error_s = kDrawnSame_s;
  config.stray.enabled = false;    // its own errors would pass for a magnet ...
  config.magnets.enabled = false;  // ... or for another pen
  return config;
}

void Update(const Config& config, const base::HallScan& as_read, State& state, base::ToolState& tool,
            bool pushed) noexcept {
  const bool old = state.currents.valid && as_read.t_ns == state.currents.t_ns;
  state.old_scans = old ? std::min(state.old_scans + 1, config.lost_after_scans) : 0;
  if (old) {
    if (state.old_scans >= config.lost_after_scans) Hold(config, as_read, state);
    state.published.limits |= base::kToolRepeated;
    tool = state.published;
    return;
  }
  if (state.scans++ == 0) Start(config, as_read, state);
  BlameFrozen(config, as_read, state);
  const bool frozen = IsAllFrozen(as_read, config.doubt.frozen_scans, state.repetition);
  std::optional<base::HallScan> zeroed;
  if (state.away.learnt) SubtractZeros(state.away, zeroed.emplace(as_read));
  const base::HallScan& scan = zeroed ? *zeroed : as_read;
  const double since_last_s = base::Elapsed_s(scan.t_ns, state.currents.t_ns);
  const CurrentHistory currents = Remember(scan, state.currents);
  LearnFromLast(config, state);
  AdvanceMains(config.mains, scan.t_ns, state.mains);
  const PenPlace place = PlaceOf(config.model, MomentScale(state.drift), state.filter);
  const PenPlace* const pen = state.warm ? &place : nullptr;
  if (LearnsDrift(config) && ArePlausible(scan.coil_current_A))
    FollowCore(config.drift, scan.coil_current_A, pen, state.drift);
  const bool wide = IsWideScan(config, state);
  if (wide) ForgetDrift(config, scan, pen, state.drift);
  const double dt_s = base::Elapsed_s(scan.t_ns, state.filter_t_ns);
  const bool continues = state.warm && dt_s >= 0 && dt_s <= config.coast_max_s;
  FilterState predicted = state.filter;
  if (continues) PredictFilter(config.filter, dt_s, pushed, predicted);
  ScanContext context{config, scan, state.currents, currents};
  std::optional<SteelResponse> steel;
  if (state.warm && HasSteel(config.model)) {
    steel = SteelResponseOf(config.model, PoseOf(predicted), MomentScale(state.drift));
    context.local = &steel->field_T;
  }
  context.stray = &state.stray;
  context.mains = FieldOfMains(state.mains);
  Measurement measurement = MeasureScan(context, state.drift, state.doubt);
  if (wide) AddAmbientColumns(measurement);

  Outcome outcome;
  KernelSums sums;
  if (!frozen && HasMagnet(config, measurement)) {
    bool tried = state.warm;
    if (state.warm) {
      outcome = TryWarm(config, predicted, wide ? &sums : nullptr, measurement);
      const bool explained = outcome.explained;
      if (outcome.good) TryJump(context, predicted, state, measurement, outcome);
      if (!outcome.good) TryOtherHypotheses(context, predicted, state, measurement, outcome);
      outcome.explained = outcome.explained || explained;
    }
    const bool warm = outcome.good;
    if (!warm && --state.cold_pause < 0) {
      const bool explained = outcome.explained;
      outcome = TryColdHypothesis(context, state, measurement);
      outcome.explained = outcome.explained || explained;
      state.cold_pause = outcome.good ? 0 : config.cold_pause_scans;
      tried = true;
    } else if (!warm && !state.warm && !state.explained) {
      outcome = TryPair(context, state, measurement);
      tried = outcome.good;
    }
    if (tried) state.explained = outcome.explained;
    if (continues && IsEarlyJump(config, state, predicted, outcome)) outcome.good = false;
    if (outcome.good && warm && outcome.fit.has_sums) {
      state.evidence = GatherEvidence(config.drift, measurement, sums, state.drift.step_s);
      state.magnet.pose_per_moment = state.evidence.pose_per_moment;
    }
    if (outcome.good && warm && steel) {
      CorrectForSteel(config.model, measurement, PoseOf(predicted), *steel, outcome.fit);
    }
    if (outcome.good && warm) DoubtOn(context, predicted, measurement, outcome, state);
    if (outcome.good && IsAbsurd(config, state)) {
      Restart(state);
      outcome.good = false;
    }
    if (outcome.good) AddMomentCovariance(state, outcome.fit);
    if (outcome.good && state.stray.on) AddStrayCovariance(config.stray, state.stray, outcome.fit);
    const double unsure =
        Unsureness(config.doubt, state.doubt, state.stray.dipole.found ? state.stray.dipole.misfit : 1);
    outcome.fit.covariance *= unsure * unsure;
  }
  state.currents = currents;
  if (!outcome.good || !Publish(config, scan, outcome, measurement.systematic_share, dt_s, continues, predicted, state))
    Hold(config, scan, state);
  LearnAway(config, scan, state.published.status == base::TrackingStatus::kAbsent && !frozen, state);
  Describe(config, scan, measurement, outcome, state.explained, state.published);
  FollowMagnet(config.magnets, state.published, since_last_s, state.doubt.left_out >= 0, state.drift, state.magnet);
  ReportFindings(state, frozen, state.published);
  tool = state.published;
}

base::ToolState Predict(const base::ToolState& tool, std::int64_t t_ns, double tip_offset_m) noexcept {
  const double dt_s = std::clamp(base::Elapsed_s(t_ns, tool.t_ns), -kPredictMax_s, kPredictMax_s);
  base::ToolState ahead = tool;
  const auto step_ns = static_cast<std::int64_t>(std::lround(dt_s * 1e9));
  if (__builtin_add_overflow(tool.t_ns, step_ns, &ahead.t_ns)) ahead.t_ns = tool.t_ns;
  ahead.position_base_m =
      base::FromEigen(base::ToEigen(tool.position_base_m) + dt_s * base::ToEigen(tool.velocity_base_m_s));
  ahead.axis_base = TurnAxis(tool.axis_base, dt_s * tool.angular_velocity_base_rad_s);
  SetDevicePoint(tip_offset_m, ahead);
  return ahead;
}

}  // namespace omni::tracker
