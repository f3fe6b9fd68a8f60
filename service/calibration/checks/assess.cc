#include "service/calibration/checks/checks.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/calibration/fit/residual.h"
#include "service/calibration/fit/tool_field.h"

namespace omni::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kUnfixed = 0.7;        // posterior deviation, in tolerances
constexpr std::size_t kProbesMax = 64;  // samples on which the expected error is taken

Matrix3d CrossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

void DescribeSensors(const Adjustment& adjustment, Report& report) {
  const Parameters& parameters = adjustment.parameters;
  for (int i = 0; i < parameters.sensors(); ++i) {
    const SensorFit& fit = adjustment.system.sensors[static_cast<std::size_t>(i)];
    const double count = std::max(1.0, fit.readings);
    const auto moved = parameters.x().segment<3>(kSensorUnknowns * i + kPositionAt);
    report.sensors.push_back({.residual_T = std::sqrt(fit.square_T2 / count),
                              .chi2_per_reading = fit.chi2 / count,
                              .moved_m = parameters.tolerances().sensor_position_m * moved.norm()});
  }
}

// The least value of the cost has as many degrees of freedom as there are readings, touches and maps, less five a
// sample: every other unknown brings its own prior. The mean gain is held, hence one more. (5.1)
void DescribeFit(const Problem& problem, const Adjustment& adjustment, Report& report) {
  double dof = 1 + adjustment.system.map_readings;
  double touch_square = 0, touches = 0;
  const auto& observations = problem.observations();
  for (std::size_t n = 0; n < observations.size(); ++n) {
    dof += observations[n].weight * (observations[n].readings - 5);
    if (!observations[n].touches_hull) continue;
    dof += observations[n].touch_weight;
    touches += observations[n].touch_weight;
    touch_square += observations[n].touch_weight * adjustment.system.samples[n].touch_chi2;
  }
  const System& system = adjustment.system;
  report.dof = static_cast<int>(dof);
  report.chi2_per_dof = system.cost / std::max(1.0, dof);
  if (touches > 0) report.touch_rms_m = adjustment.parameters.tolerances().touch_m * std::sqrt(touch_square / touches);
  if (system.map_readings > 0) report.map_chi2_per_reading = system.map_chi2 / system.map_readings;
}

bool IsCentre(int shared) { return shared >= kCentreAt && shared < kCentreAt + 3; }

bool IsCalibrated(const Parameters& parameters, int index) {
  const int shared = index - parameters.shared_at();
  const bool has_core = parameters.nominal().core_radius_m > 0;
  if (shared == kSteelAt || shared == kSteelDepthAt) return true;
  return shared < 0 || shared == kMomentAt || (has_core && (shared == kKappaAt || IsCentre(shared)));
}

// Information of the data alone = reduced normal matrix less the priors; an eigenvalue below 1 means less than theirs
// (5.2). As many of D are negative as eigenvalues of I - 1 = L D L^T are [Sylvester's law of inertia].
void DescribeObservability(const Adjustment& adjustment, Report& report) {
  const Parameters& parameters = adjustment.parameters;
  MatrixXd information = EliminateSamples(adjustment.system, 0).H;
  information.diagonal().array() -= 2;
  report.weak_directions = static_cast<int>((information.ldlt().vectorD().array() < 0).count());
  for (int e = 0; e < parameters.size(); ++e) {
    const double sigma = std::sqrt(adjustment.covariance(e, e));
    const bool of_steel = e >= parameters.shared_at() + kSteelAt && e <= parameters.shared_at() + kSteelDepthAt;
    if (!IsCalibrated(parameters, e) || of_steel || !(sigma > kUnfixed)) continue;
    const double tolerance = parameters.ToleranceInUnit(e);
    report.unfixed.push_back({parameters.Name(e), sigma * tolerance, tolerance, parameters.Unit(e)});
  }
}

// Rotation of all sensors about the core that best fits their displacements, w = (sum [s]^T [s])^-1 sum s x ds: its
// deviation shows how well the frame is fixed. (5.3)
double FrameRotation(const Adjustment& adjustment) {
  const Parameters& parameters = adjustment.parameters;
  MatrixXd J = MatrixXd::Zero(3, parameters.size());
  Matrix3d inertia = Matrix3d::Zero();
  for (int i = 0; i < parameters.sensors(); ++i) {
    const Matrix3d s = CrossMatrix(parameters.Sensor(i).position_base_m);
    inertia += s.transpose() * s;
    J.middleCols<3>(kSensorUnknowns * i + kPositionAt) = parameters.tolerances().sensor_position_m * s;
  }
  J = (inertia.inverse() * J).eval();
  return std::sqrt((J * adjustment.covariance * J.transpose()).trace() / 3);
}

// A pose follows the array as dp = -H_n^-1 C dx, and the core's centre, from which it is measured: the covariance of x
// gives the error that remains in poses. (5.4)
double ExpectedError(const Adjustment& adjustment, const MatrixXd& covariance) {
  const Parameters& parameters = adjustment.parameters;
  const auto& samples = adjustment.system.samples;
  const std::size_t stride = std::max<std::size_t>(1, samples.size() / kProbesMax);
  double square_m2 = 0, count = 0;
  for (std::size_t n = 0; n < samples.size(); n += stride, ++count) {
    MatrixXd K = samples[n].H.llt().solve(samples[n].C).topRows<3>();
    K.middleCols<3>(parameters.shared_at() + kCentreAt) -= parameters.tolerances().core_centre_m * Matrix3d::Identity();
    for (int e = 0; e < parameters.size(); ++e) {
      if (!IsCalibrated(parameters, e)) K.col(e).setZero();
    }
    square_m2 += (K * covariance * K.transpose()).trace();
  }
  return count > 0 ? std::sqrt(square_m2 / count) : 0.0;
}

// Of every touch as if the fit had not used it, in standard deviations, rms: r / sqrt(1 - leverage), which a linear fit
// without it would give; and all touches' share in S. (5.5), (5.6)
struct Touches {
  double held_out = 0;
  MatrixXd information;
};
Touches CheckTouches(const Problem& problem, const Adjustment& adjustment) {
  const Parameters& parameters = adjustment.parameters;
  const double sigma_m = problem.touch_sigma_m();
  double square = 0, count = 0;
  Touches touches;
  touches.information.setZero(parameters.size(), parameters.size());
  for (std::size_t n = 0; n < adjustment.instants.size(); ++n) {
    const Observation& observation = problem.observations()[n];
    if (!observation.touches_hull) continue;
    const Instant& instant = adjustment.instants[n];
    const SampleBlock& block = adjustment.system.samples[n];
    const TouchResidual touch = CompareTouch(parameters, MakeToolFrame(instant.position_base_m, instant.axis_base));
    OwnVector by_own = OwnVector::Zero();
    by_own.head<5>() = touch.by_pose.transpose();
    const OwnVector solved = block.H.llt().solve(by_own);
    Eigen::RowVectorXd by_array = -solved.transpose() * block.C;
    by_array.segment<kSampleShared>(parameters.shared_at()) += touch.by_shared;
    touches.information += (observation.touch_weight / (sigma_m * sigma_m)) * by_array.transpose() * by_array;
    const double fitted_m2 = by_own.dot(solved) + by_array * adjustment.covariance * by_array.transpose();
    const double leverage = std::min(0.99, observation.touch_weight * fitted_m2 / (sigma_m * sigma_m));
    square += observation.touch_weight * block.touch_chi2 / (1 - leverage);
    count += observation.touch_weight;
  }
  touches.held_out = count > 0 ? std::sqrt(square / count) : 1.0;
  return touches;
}

// Touches that lie closer to the hull than their assumed error leave less of an error than S implies:
//   S^-1 - (1 - q^2) S^-1 T S^-1,   T: their part of S, q < 1: their rms in deviations                       (5.6)
MatrixXd CovarianceByTouches(const Adjustment& adjustment, const Touches& touches) {
  const double left = std::min(1.0, touches.held_out * touches.held_out);
  return adjustment.covariance - (1 - left) * (adjustment.covariance * touches.information * adjustment.covariance);
}

}  // namespace

Report AssessAdjustment(const Problem& problem, const Adjustment& adjustment) {
  const Parameters& parameters = adjustment.parameters;
  const int moment = parameters.shared_at() + kMomentAt;
  Report report;
  DescribeSensors(adjustment, report);
  DescribeFit(problem, adjustment, report);
  DescribeObservability(adjustment, report);
  report.moment_relative = parameters.tolerances().moment * parameters.x()[moment];
  report.moment_sigma = parameters.tolerances().moment * std::sqrt(adjustment.covariance(moment, moment));
  report.moment_drift = parameters.tolerances().moment_drift * parameters.x()[parameters.shared_at() + kMomentDriftAt];
  report.frame_rotation_rad = FrameRotation(adjustment);
  // Every sign that the model leaves something out makes the error larger.
  const double misfit = std::sqrt(report.chi2_per_dof);
  const Touches touches = CheckTouches(problem, adjustment);
  report.expected_error_m =
      std::max({1.0, misfit, touches.held_out}) * ExpectedError(adjustment, CovarianceByTouches(adjustment, touches));
  report.iterations = adjustment.iterations;
  return report;
}

}  // namespace omni::calibration
