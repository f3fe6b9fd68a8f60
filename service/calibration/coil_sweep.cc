#include "service/calibration/coil_sweep.h"

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

}  // namespace

std::vector<SweepStep> MakeSweep(const SweepPlan& plan) {
  std::vector<SweepStep> steps;
  for (int repeat = 0; repeat < plan.repeats; ++repeat) {
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      // The order turns round, so that what the core remembers of the step before cancels.
      const double first_A = repeat % 2 == 0 ? plan.amplitude_A : -plan.amplitude_A;
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

void CoilSweep::Add(const base::HallScan& scan, bool rest) {
  double change_A = 0;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    change_A = std::max(change_A, std::abs(scan.coil_current_A[k] - last_current_A_[k]));
  }
  last_current_A_ = scan.coil_current_A;
  steady_scans_ = change_A <= kSteady_A ? steady_scans_ + 1 : 0;
  if (steady_scans_ < kSettleScans) return;
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
  if (rest) {
    rest_sum_ += reading;
    rest_current_sum_A_ += current_A;
    ++rest_scans_;
    return;
  }
  Eigen::Matrix<double, kRegressors, 1> regressor;
  regressor << 1, current_A;
  N_ += regressor * regressor.transpose();
  right_ += regressor * reading.transpose();
  square_ += reading.cwiseAbs2();
  ++scans_;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    highest_A_[k] = std::max(highest_A_[k], scan.coil_current_A[k]);
    lowest_A_[k] = std::min(lowest_A_[k], scan.coil_current_A[k]);
  }
}

base::Result<std::vector<CoilResponse>> CoilSweep::Finish() const {
  const auto refused = [](const std::string& why) { return base::Error{"coil sweep refused: " + why}; };
  if (!(bad_scans_ <= 0.05 * (scans_ + rest_scans_))) {
    return refused(std::to_string(bad_scans_) +
                   " scans were saturated or not a number; take the pen and other magnets away and sweep anew");
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
  // reading = constant + A I: the constant takes what hysteresis leaves on average, the rest gives the background.
  const Eigen::LDLT<Eigen::Matrix<double, kRegressors, kRegressors>> solver(N_);
  const Eigen::Matrix<double, kRegressors, kReadings> fit = solver.solve(right_);
  if (!fit.allFinite()) return refused("the currents do not tell the coils apart; sweep them one by one");
  const Eigen::Matrix<double, kReadings, 1> explained = (fit.cwiseProduct(right_)).colwise().sum().transpose();
  const Vector3d rest_A = rest_current_sum_A_ / rest_scans_;
  const double current_rms_A = std::sqrt(N_.diagonal().tail<3>().minCoeff() / scans_);
  std::vector<CoilResponse> responses(base::kSensorCount);
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const int at = 3 * static_cast<int>(i);
    const RowMajor3d map = fit.block<3, 3>(1, at).transpose();
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
