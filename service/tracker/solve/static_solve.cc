#include "service/tracker/solve/static_solve.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "service/base/eigen.h"

namespace omni::tracker {
namespace {

constexpr double kGateDof = 19;  // 24 readings, 5 unknowns

bool IsFinite(const base::Vec3& v) noexcept { return std::isfinite(v.x + v.y + v.z); }

template <std::size_t kSize>
bool IsFinite(const std::array<double, kSize>& values) noexcept {
  double sum = 0;
  for (const double value : values) sum += value;
  return std::isfinite(sum);
}

base::Status CheckSensors(const base::Calibration& calibration) {
  const auto count = static_cast<int>(calibration.sensors.size());
  if (!(count >= base::kArraySensorsMin && count <= base::kArraySensorsMax)) {
    return base::Error{"sensors: " + std::to_string(count) + " given, but the tracker takes " +
                       std::to_string(base::kArraySensorsMin) + " to " + std::to_string(base::kArraySensorsMax)};
  }
  for (int i = 0; i < count; ++i) {
    const base::SensorCalibration& sensor = calibration.sensors[static_cast<std::size_t>(i)];
    if (!IsFinite(sensor.position_base_m) || !IsFinite(sensor.background_sensor_T) ||
        !IsFinite(sensor.gain_sensor_base) || !IsFinite(sensor.current_map_T_A)) {
      return base::Error{"sensor " + std::to_string(i) +
                         ": position, gain, current map and background must be finite numbers"};
    }
  }
  for (const double noise_T : calibration.sensor_noise_T) {
    if (!(noise_T > 0 && noise_T < 1)) {
      return base::Error{"sensor noise: every axis needs a value above 0 T (e.g. 4e-7), got " +
                         std::to_string(noise_T)};
    }
  }
  return base::Ok{};
}

base::Status Check(const base::Calibration& calibration) {
  if (base::Status sensors = CheckSensors(calibration); !sensors.ok()) return sensors;
  const base::MagnetGeometry& magnet = calibration.magnet;
  if (!(calibration.moment_Am2 > 0 && calibration.moment_Am2 < 1e4)) {
    return base::Error{"magnet: moment must be above 0 and below 1e4 A m^2, got " +
                       std::to_string(calibration.moment_Am2)};
  }
  const bool sized =
      magnet.radius_m > 0 && magnet.radius_m < 1 &&
      (magnet.shape == base::MagnetShape::kSphere || (magnet.half_height_m > 0 && magnet.half_height_m < 1));
  if (!sized) return base::Error{"magnet: radius and height must be above 0 and below 1 m"};
  if (!(calibration.core_radius_m >= 0 && calibration.core_radius_m < 1 && calibration.hull_radius_m >= 0 &&
        calibration.hull_radius_m < 1 && std::isfinite(calibration.core_kappa))) {
    return base::Error{"core, hull: radii must be 0 (none) or below 1 m"};
  }
  return base::Ok{};
}

// n = -S C^T r, and y - model - C n in tesla.
void Explain(const Model& model, const ArrayMeasurement& measurement, StaticPose& result) noexcept {
  std::array<double, std::size_t{3} * kArraySensors> field{};
  std::array<std::array<double, kParameters>, std::size_t{3} * kArraySensors> jacobian;
  EvaluateField(model, MakePosePoint(result.pose), field, jacobian);
  const auto sensors = static_cast<std::size_t>(model.sensors);
  const auto nuisances = static_cast<std::size_t>(measurement.nuisances);
  std::array<double, kNuisancesMax> Ctr{};
  for (std::size_t i = 0; i < sensors; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double r = measurement.whitened[axis][i] - measurement.inverse_sigma[axis][i] * field[3 * i + axis];
      for (std::size_t n = 0; n < nuisances; ++n) Ctr[n] += measurement.nuisance[3 * n + axis][i] * r;
    }
  }
  result.nuisance = {};
  for (std::size_t a = 0; a < nuisances; ++a) {
    for (std::size_t b = 0; b < nuisances; ++b) {
      result.nuisance[a] += measurement.nuisance_covariance[a * kNuisancesMax + b] * Ctr[b];
    }
  }
  for (std::size_t i = 0; i < sensors; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double w = measurement.inverse_sigma[axis][i];
      double r = measurement.whitened[axis][i] - w * field[3 * i + axis];
      for (std::size_t n = 0; n < nuisances; ++n) r -= measurement.nuisance[3 * n + axis][i] * result.nuisance[n];
      result.residual_T[3 * i + axis] = w > 0 ? r / w : std::numeric_limits<double>::quiet_NaN();
    }
  }
}

}  // namespace

double ChiSquareGate(double chi2_max, int dof) noexcept {
  return dof + (chi2_max - kGateDof) * std::sqrt(dof / kGateDof);
}

StaticSolver::StaticSolver(Model model, const StaticOptions& options) : model_(std::move(model)), options_(options) {}

base::Result<StaticSolver> StaticSolver::Make(const base::Calibration& calibration, const StaticOptions& options) {
  if (const base::Status status = Check(calibration); !status.ok()) return base::Error{status.error()};
  return StaticSolver(MakeModel(calibration, options.rung), options);
}

StaticPose StaticSolver::Solve(std::span<const ArrayReading> readings,
                               const std::array<double, base::kCoilCount>& coil_current_A,
                               const std::optional<Pose>& start) const noexcept {
  StaticPose result;
  ArrayMeasurement measurement;
  if (readings.size() == static_cast<std::size_t>(model_.sensors)) {
    MakeArrayMeasurement(model_, options_.trust, readings.data(), coil_current_A, measurement);
  }
  result.dof = measurement.axes - measurement.fixed - options_.parameters;
  if (!(result.dof >= 0)) {
    result.status = StaticStatus::kTooFew;
    return result;
  }
  const double gate = ChiSquareGate(options_.chi2_max, result.dof);
  SolveOptions solve{.precision = options_.precision, .parameters = options_.parameters, .chord = false};
  const auto attempt = [&](const Pose& from) {
    const Fit fit = SolvePose(model_, measurement, from, solve);
    result.iterations += fit.iterations;
    if (!fit.converged || (result.status == StaticStatus::kPoorFit && !(fit.chi2 < result.chi2))) return false;
    result.status = fit.chi2 <= gate ? StaticStatus::kFound : StaticStatus::kPoorFit;
    result.pose = fit.pose;
    result.covariance = fit.covariance;
    result.chi2 = fit.chi2;
    return result.status == StaticStatus::kFound;
  };
  solve.iterations_max = options_.warm_iterations_max;
  const Eigen::Vector3d centre(model_.core_centre_base_m.data());
  const bool found = start.has_value() && attempt({start->position_base_m - centre, start->axis_base});
  if (!found && options_.parameters == kParameters) {
    result.cold = true;
    solve.iterations_max = options_.cold_iterations_max;
    solve.damping = kColdDamping;
    const ColdCandidates candidates = RankGrid(model_, measurement, options_.cold_candidates);
    for (std::size_t c = 0; c < static_cast<std::size_t>(candidates.count); ++c) {
      if (attempt(candidates.poses[c])) break;
    }
  }
  if (result.status == StaticStatus::kFound || result.status == StaticStatus::kPoorFit) {
    Explain(model_, measurement, result);
    result.pose.position_base_m += centre;
  }
  return result;
}

}  // namespace omni::tracker
