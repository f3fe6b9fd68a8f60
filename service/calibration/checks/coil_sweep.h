// Current maps and background of every sensor from a sweep of the coils without the pen. docs/theory/calibration.md
// (6.2)
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "service/base/hall_scan.h"
#include "service/base/result.h"
#include "service/calibration/types.h"

namespace omni::calibration {

// Each coil to + and - amplitude_A, then the same with small_share of it, then falling alternation that wipes the
// core's memory, then rest.
struct SweepPlan {
  double amplitude_A = 4;
  int plateau_scans = 150;
  int repeats = 2;            // of each amplitude
  double small_share = 0.15;  // what the core keeps (hysteresis) does not grow with the current: two amplitudes show it
  int wipe_steps = 24;        // of alternating sign, each at 0.7 of the one before: to less than turns the core over
  int wipe_scans = 30;
  int rest_scans = 1000;
};
// Set-points in order, each for so many scans.
struct SweepStep {
  std::array<double, base::kCoilCount> current_A{};
  int scans = 0;
  bool rest = false;
};
std::vector<SweepStep> MakeSweep(const SweepPlan& plan);

class CoilSweep {
 public:
  // `rest`: coils at zero, at the end of the plan. Scans soon after a change of current are left out.
  void Add(const base::HallScan& scan, bool rest);

  // One per sensor; rejects data that give no map, with the reason.
  base::Result<std::vector<CoilResponse>> Finish() const;

 private:
  // Constant, currents, hysteresis, eddy currents. docs/theory/calibration.md (6.2)
  static constexpr int kCurrentsAt = 1, kKeptAt = 4, kLagAt = 7, kRegressors = 10;
  static constexpr int kReadings = 3 * base::kSensorCount;

  using Regressor = Eigen::Matrix<double, kRegressors, 1>;
  struct Step {
    double scan = 0;  // when
    Eigen::Vector3d change_A = Eigen::Vector3d::Zero();
  };

  void CheckSensors(const base::HallScan& scan);
  std::string SensorProblem() const;
  void FollowSteps(const Eigen::Vector3d& current_A);
  Regressor MakeRegressor(const Eigen::Vector3d& current_A) const;

  int steady_scans_ = 0;
  double scan_ = 0;                                           // since the start
  double step_scan_ = 0;                                      // when the current began to change
  std::vector<Step> steps_;                                   // that have settled
  Eigen::Vector3d settled_A_ = Eigen::Vector3d::Zero();       // of the last plateau
  Eigen::Vector3d last_direction_ = Eigen::Vector3d::Zero();  // from the plateau before to it
  std::array<double, base::kCoilCount> last_current_A_{};
  Eigen::Matrix<double, kRegressors, kRegressors> N_ = Eigen::Matrix<double, kRegressors, kRegressors>::Zero();
  Eigen::Matrix<double, kRegressors, kReadings> right_ = Eigen::Matrix<double, kRegressors, kReadings>::Zero();
  Eigen::Matrix<double, kReadings, 1> square_ = Eigen::Matrix<double, kReadings, 1>::Zero();
  Eigen::Matrix<double, kReadings, 1> rest_sum_ = Eigen::Matrix<double, kReadings, 1>::Zero();
  Eigen::Vector3d rest_current_sum_A_ = Eigen::Vector3d::Zero();
  std::array<double, base::kCoilCount> highest_A_{}, lowest_A_{};
  double scans_ = 0, rest_scans_ = 0;
  int bad_scans_ = 0;  // saturated or not a number
  // Number of steady scans by sensor: not a number or stale; the same reading again.
  std::array<int, base::kSensorCount> silent_{}, repeats_{};
  std::array<base::Vec3, base::kSensorCount> last_T_{};
  int looks_ = 0;
};

}  // namespace omni::calibration
