#include "service/calibration/checks/coil_sweep.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace omni::calibration {
namespace {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr int kSettleScans = 25;    // current lag, eddies and sample ages have died out
constexpr double kSteady_A = 0.05;  // change from scan to scan that is noise of the current sensor
constexpr double kSwingMin_A = 1;   // each way
constexpr double kScansMin = 200;
constexpr double kWipeRatio = 0.7;
constexpr double kStepMin_A = 0.1;  // less does not turn over what the core keeps
constexpr double kNoise_T = 1e-6;   // for the two priors below
constexpr double kKept_T = 3e-6;    // field that the core keeps, at a sensor
constexpr double kLag_T = 3e-7;     // of one of the core's eddy currents at a sensor, after a step of 1 A
constexpr double kEddy_s = 0.14;    // the slowest of them, in 15 mm of soft iron
constexpr int kEddyTerms = 8;
constexpr double kMostly = 0.9;  // of the scans

// How eddy currents die out in a solid sphere: like the root of time at first, exponentially in the end.
//   sum_n exp(-(y_n / y_1)^2 t / tau),   y_n = (n + .43) pi about, the zeros of the spherical Bessel function j1
double EddyTail(double t_s) {
  double sum = 0;
  for (int n = 1; n <= kEddyTerms; ++n) {
    const double ratio = (n + 0.43) / 1.43;
    sum += std::exp(-ratio * ratio * t_s / kEddy_s);
  }
  return sum;
}

}  // namespace

std::vector<SweepStep> MakeSweep(const SweepPlan& plan) {
  std::vector<SweepStep> steps;
  for (int repeat = 0; repeat < 2 * plan.repeats; ++repeat) {
    const double amplitude_A = plan.amplitude_A * (repeat < plan.repeats ? 1 : plan.small_share);
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      // The order reverses, so that the core's memory of the step before cancels.
      const double first_A = repeat % 2 == 0 ? amplitude_A : -amplitude_A;
      for (const double current_A : {first_A, -first_A}) {
        SweepStep step{{}, plan.plateau_scans, false};
        step.current_A[k] = current_A;
        steps.push_back(step);
      }
    }
  }
  double wipe_A = plan.amplitude_A;
  for (int i = 0; i < plan.wipe_steps; ++i, wipe_A *= -kWipeRatio) {
    steps.push_back({{wipe_A, wipe_A, wipe_A}, plan.wipe_scans, false});
  }
  steps.push_back({{}, plan.rest_scans, true});
  return steps;
}

// A plateau that has settled shows the step that led to it.
void CoilSweep::FollowSteps(const Vector3d& current_A) {
  const Vector3d change_A = current_A - settled_A_;
  if (!(change_A.norm() > kStepMin_A)) return;
  last_direction_ = change_A.normalized();
  steps_.push_back({step_scan_, change_A});
  settled_A_ = current_A;
}

CoilSweep::Regressor CoilSweep::MakeRegressor(const Vector3d& current_A) const {
  Vector3d lag = Vector3d::Zero();
  for (const Step& step : steps_) lag -= EddyTail((scan_ - step.scan) * base::kTickPeriod_s) * step.change_A;
  Regressor regressor;
  regressor << 1, current_A, -last_direction_, lag;
  return regressor;
}

void CoilSweep::Add(const base::HallScan& scan, bool rest) {
  ++scan_;
  double change_A = 0;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    change_A = std::max(change_A, std::abs(scan.coil_current_A[k] - last_current_A_[k]));
  }
  last_current_A_ = scan.coil_current_A;
  if (change_A > kSteady_A && steady_scans_ > 0) step_scan_ = scan_ - 1;
  steady_scans_ = change_A <= kSteady_A ? steady_scans_ + 1 : 0;
  if (steady_scans_ < kSettleScans) return;
  CheckSensors(scan);
  Eigen::Matrix<double, kReadings, 1> reading;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const base::Vec3& B = scan.field_sensor_T[i];
    reading.segment<3>(3 * static_cast<int>(i)) = Vector3d(B.x, B.y, B.z);
  }
  const Vector3d current_A = Eigen::Map<const Vector3d>(scan.coil_current_A.data());
  if (scan.saturated_mask != 0 || !reading.allFinite() || !current_A.allFinite()) {
    ++bad_scans_;
    return;
  }
  FollowSteps(current_A);
  if (rest) {
    rest_sum_ += reading;
    rest_current_sum_A_ += current_A;
    ++rest_scans_;
    return;
  }
  const Regressor regressor = MakeRegressor(current_A);
  N_ += regressor * regressor.transpose();
  right_ += regressor * reading.transpose();
  square_ += reading.cwiseAbs2();
  ++scans_;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    highest_A_[k] = std::max(highest_A_[k], scan.coil_current_A[k]);
    lowest_A_[k] = std::min(lowest_A_[k], scan.coil_current_A[k]);
  }
}

void CoilSweep::CheckSensors(const base::HallScan& scan) {
  ++looks_;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const base::Vec3& B = scan.field_sensor_T[i];
    const bool silent = base::IsSilentSensor(scan, i);
    silent_[i] += silent ? 1 : 0;
    repeats_[i] += B == last_T_[i] ? 1 : 0;
    last_T_[i] = B;
  }
}

// A sensor that shows nothing of the coils; where all repeat themselves, they have no noise.
std::string CoilSweep::SensorProblem() const {
  const auto mostly = [this](int scans) { return scans > 0 && scans > kMostly * looks_; };
  const bool all = std::all_of(repeats_.begin(), repeats_.end(), mostly);
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const char* what = mostly(silent_[i])            ? " gives nothing (not a number, or too old)"
                       : !all && mostly(repeats_[i]) ? " repeats itself"
                                                     : nullptr;
    if (what != nullptr) return "sensor " + std::to_string(i) + what + "; check its cable and address";
  }
  return {};
}

base::Result<std::vector<CoilResponse>> CoilSweep::Finish() const {
  const auto refused = [](const std::string& why) { return base::Error{"coil sweep refused: " + why}; };
  if (const std::string why = SensorProblem(); !why.empty()) return refused(why);
  if (!(bad_scans_ <= 0.05 * (scans_ + rest_scans_))) {
    return refused(std::to_string(bad_scans_) +
                   " scans were saturated or not a number; take the pen and other magnets away and sweep again");
  }
  if (!(scans_ >= kScansMin && rest_scans_ >= kScansMin)) {
    return refused("only " + std::to_string(static_cast<int>(scans_)) + " steady scans and " +
                   std::to_string(static_cast<int>(rest_scans_)) + " at rest, at least 200 of each are needed");
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    if (highest_A_[k] >= kSwingMin_A && lowest_A_[k] <= -kSwingMin_A) continue;
    char range[64];
    std::snprintf(range, sizeof range, "%.2f to %.2f A", lowest_A_[k], highest_A_[k]);
    return refused("coil " + std::string(1, "xyz"[k]) + " carried " + range +
                   ", at least -1 to 1 A are needed; check its driver and supply");
  }
  // reading = constant + A I - K (direction of the last step) - E sum step EddyTail(time since it): the core's
  // remanence lags behind the last step whatever its size, so that without K it would pass for a smaller A. The priors
  // of K and E decide where a plan does not separate them from A.
  Eigen::Matrix<double, kRegressors, kRegressors> N = N_;
  const double kept = kNoise_T / kKept_T, lag = kNoise_T / kLag_T;
  N.diagonal().segment<3>(kKeptAt).array() += kept * kept;
  N.diagonal().segment<3>(kLagAt).array() += lag * lag;
  const Eigen::LDLT<Eigen::Matrix<double, kRegressors, kRegressors>> solver(N);
  const Eigen::Matrix<double, kRegressors, kReadings> fit = solver.solve(right_);
  if (!fit.allFinite()) return refused("the currents do not distinguish the coils; sweep them one by one");
  const Eigen::Matrix<double, kReadings, 1> explained = (fit.cwiseProduct(right_)).colwise().sum().transpose();
  const Vector3d rest_A = rest_current_sum_A_ / rest_scans_;
  const double current_rms_A = std::sqrt(N_.diagonal().segment<3>(kCurrentsAt).minCoeff() / scans_);
  std::vector<CoilResponse> responses(base::kSensorCount);
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const int at = 3 * static_cast<int>(i);
    const RowMajor3d map = fit.block<3, 3>(kCurrentsAt, at).transpose();
    Eigen::Map<RowMajor3d>(responses[i].map_sensor_T_A.data()) = map;
    const Vector3d background = rest_sum_.segment<3>(at) / rest_scans_ - map * rest_A;
    responses[i].background_sensor_T = {background.x(), background.y(), background.z()};
    // What is left over repeats with each plateau (hysteresis), so that it does not average out over scans.
    const double left_square = std::max(0.0, (square_ - explained).segment<3>(at).mean() / scans_);
    responses[i].map_error_T_A = std::sqrt(left_square) / (current_rms_A * std::sqrt(kSettleScans));
  }
  return responses;
}

}  // namespace omni::calibration
