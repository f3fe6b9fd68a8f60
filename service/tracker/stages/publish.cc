#include "service/tracker/stages/publish.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "service/base/clock.h"
#include "service/base/eigen.h"
#include "service/tracker/filter/filter.h"
#include "service/tracker/kernel/matrices.h"
#include "service/tracker/solve/gap.h"

namespace omni::tracker {
namespace {

using Eigen::Vector3d;

constexpr double kPredictMax_s = 0.020;
constexpr double kTypicalRadius_m = 0.065;  // from the pen to the core

PoseMeasurement ToMeasurement(const Fit& fit) noexcept {
  PoseMeasurement measured{base::FromEigen(fit.pose.position_base_m), base::FromEigen(fit.pose.axis_base), {}};
  AsMatrix<kParameters>(measured.covariance) = fit.covariance;
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

// The filter's covariance plus the share of the fit's that no filtering removes.
base::ToolState MakeToolState(const Model& model, const base::HallScan& scan, const PoseMeasurement& measured,
                              double systematic, const FilterState& filter) noexcept {
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

std::uint32_t LimitsOf(const Observation& observation, const Fit& fit, bool explained,
                       const base::ToolState& tool) noexcept {
  const Config& config = observation.config;
  const Measurement& measurement = observation.explanation.measurement;
  const Vector3d p = base::ToEigen(tool.position_base_m);
  const bool saturated = (observation.received.scan().saturated_mask & ((1u << kReadings) - 1)) != 0;
  std::uint32_t limits = 0;
  if (std::abs(p.dot(base::ToEigen(tool.axis_base))) < config.tilted_cos * p.norm()) limits |= base::kToolTilted;
  if (!(PositionVariance(fit) <= config.coarse_m * config.coarse_m)) limits |= base::kToolCoarse;
  if (measurement.axes <= kReadings / 2) limits |= base::kToolFewReadings;
  if (saturated) limits |= base::kToolSensorSaturated;
  if (!explained && HasMagnet(config, measurement)) limits |= base::kToolContradicted;
  return limits;
}

void Describe(const Observation& observation, const Fit& fit, bool explained, base::ToolState& tool) noexcept {
  const Measurement& measurement = observation.explanation.measurement;
  tool.chi2 = std::isfinite(fit.chi2) ? fit.chi2 : std::numeric_limits<double>::max();
  tool.dof = std::max(0, measurement.axes - measurement.fixed - kParameters);
  tool.iterations = fit.iterations;
  tool.hypothesis = observation.good() ? observation.explanation.by->name : nullptr;
  tool.field_rms_T = measurement.field_rms_T;
  tool.limits = LimitsOf(observation, fit, explained, tool);
}

// Holds the last pose while the velocities fade.
void Hold(const Config& config, const base::HallScan& scan, PoseState& pose) noexcept {
  base::ToolState& tool = pose.published;
  const double dt_s = std::clamp(base::Elapsed_s(scan.t_ns, tool.t_ns), 0.0, 1.0);
  const bool absent = WillBeAbsent(config, pose);
  pose.bad_scans = std::min(pose.bad_scans + 1, config.lost_after_scans);
  const double fade = absent ? 0.0 : std::exp(-dt_s / config.velocity_decay_s);
  tool.t_ns = scan.t_ns;
  tool.status = absent ? base::TrackingStatus::kAbsent : base::TrackingStatus::kLost;
  tool.velocity_base_m_s = fade * tool.velocity_base_m_s;
  tool.angular_velocity_base_rad_s = fade * tool.angular_velocity_base_rad_s;
  tool.device_point_velocity_base_m_s = fade * tool.device_point_velocity_base_m_s;
  if (absent) pose.warm = false;
}

// Of a pen whose moment is not known as well as that of the calibrated one.
void AddMomentCovariance(const RoomState& room, Fit& fit) noexcept {
  const double variance = PublishedVariance(room.drift, room.magnet);
  if (!(variance > 0)) return;
  const auto shift = AsVector(room.magnet.pose_per_moment);
  fit.covariance += variance * shift * shift.transpose();
}

// With what room and calibration add to the fit's covariance.
Fit WithDoubts(const Config& config, const RoomState& room, const Outcome& outcome) noexcept {
  Fit fit = outcome.fit;
  if (outcome.good) AddMomentCovariance(room, fit);
  if (outcome.good && room.stray.on) AddStrayCovariance(config.stray, room.stray, fit);
  const FollowedDipole* magnet = room.stray.dipole.followed();
  const double unsure = SigmaFactor(config.doubt, room.doubt, magnet != nullptr ? magnet->misfit : 1);
  fit.covariance *= unsure * unsure;
  return fit;
}

// False when arithmetic went wrong, which only a hostile scan could cause.
bool Correct(const Observation& observation, const Fit& fit, FilterState& filter, State& state) noexcept {
  const Config& config = observation.config;
  const base::HallScan& scan = observation.received.scan();
  const Predicted& predicted = observation.predicted;
  const PoseMeasurement measured = ToMeasurement(fit);
  const bool restarts = !predicted.continues || observation.explanation.outcome.cold;
  if (restarts) {
    ResetFilter(config.filter, measured, filter);
    state.pose.cold_scan = state.room.scans;
  } else {
    CorrectFilter(config.filter, measured, predicted.dt_s, filter);
  }
  const double systematic = observation.explanation.measurement.systematic_share;
  const base::ToolState tool = MakeToolState(config.model, scan, measured, systematic, filter);
  if (!IsFinite(tool)) return false;
  PoseState& pose = state.pose;
  pose.published = tool;
  pose.filter = filter;
  pose.filter_t_ns = scan.t_ns;
  pose.warm = pose.ever_tracked = true;
  pose.bad_scans = state.search.cold_pause = 0;
  state.search.pair.step = PairStart::Step::kNone;
  return true;
}

// What was found to be wrong together with the pose, which is in `tool`. frozen: every sensor repeats itself.
void ReportFindings(const RoomState& room, bool frozen, base::ToolState& tool) noexcept {
  const Doubt& doubt = room.doubt;
  if (frozen) tool.limits |= base::kToolFrozen;
  tool.sensors_left_out = doubt.left_out >= 0 ? 1u << doubt.left_out : 0;
  tool.sensors_disagree = doubt.agreed == 0 ? tool.sensors_left_out : 0;
  const auto [x_T, y_T, z_T] = AmbientField_T(room.drift);
  tool.ambient_base_T = {x_T, y_T, z_T};
  tool.stray_rms_T = room.stray.believed ? RootMeanSquare(room.stray.mean_T) : 0;
  ReportMagnet(room.drift, room.magnet, tool);
  tool.model_error_relative = doubt.model_error;
}

}  // namespace

bool WillBeAbsent(const Config& config, const PoseState& pose) noexcept {
  return pose.bad_scans + 1 >= config.lost_after_scans || !pose.ever_tracked;
}

void Publish(const Observation& observation, FilterState& filter, State& state) noexcept {
  const Config& config = observation.config;
  const Explanation& explanation = observation.explanation;
  const Fit fit = WithDoubts(config, state.room, explanation.outcome);
  base::ToolState& tool = state.pose.published;
  if (!observation.good() || !Correct(observation, fit, filter, state))
    Hold(config, observation.received.scan(), state.pose);
  Describe(observation, fit, state.search.explained, tool);
  FollowMagnet(config.magnets, tool, observation.received.since_last_s, state.room.doubt.left_out >= 0,
               state.room.drift, state.room.magnet);
  ReportFindings(state.room, observation.received.frozen, tool);
}

void PublishRepeated(const Config& config, const base::HallScan& scan, State& state) noexcept {
  if (state.room.old_scans >= config.lost_after_scans) Hold(config, scan, state.pose);
  state.pose.published.limits |= base::kToolRepeated;
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
