#include "tests/support/rig/calibration_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "service/base/eigen.h"
#include "service/tracker/solve/static_solve.h"

namespace omni::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegrees = 57.29577951308232;
tracker::StaticPose SolveCold(const tracker::StaticSolver& solver, const base::HallScan& scan) {
  std::array<tracker::ArrayReading, base::kSensorCount> readings;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    readings[i] = {scan.field_sensor_T[i], (scan.saturated_mask >> (3 * i)) & 7U};
  }
  return solver.Solve(readings, scan.coil_current_A);
}

struct Pair {
  Vector3d truth, error;
};

// w minimises sum |e - w x p|^2:  sum (|p|^2 I - p p^T) w = sum p x e
Vector3d BestRotation(const std::vector<Pair>& pairs) {
  Matrix3d N = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Pair& pair : pairs) {
    N += pair.truth.squaredNorm() * Matrix3d::Identity() - pair.truth * pair.truth.transpose();
    right += pair.truth.cross(pair.error);
  }
  return N.inverse() * right;
}

}  // namespace

base::Result<CalibrationError> MeasureCalibrationError(sim::Rig& rig, const base::Calibration& calibration,
                                                       const ErrorOptions& options) {
  tracker::StaticOptions how;
  how.trust.model_error_relative = options.model_error_relative;
  const auto solver = tracker::StaticSolver::Make(calibration, how);
  if (!solver.ok()) return base::Error{solver.error()};
  sim::Random random(options.seed);
  std::vector<Pair> pairs;
  CalibrationError error;
  for (int n = 0; n < options.poses; ++n) {
    const sim::MagnetPose truth = rig.DrawPose(options.range, random);
    base::HallScan scan = rig.Scan(&truth, {}, random);
    if (options.swept) scan.coil_current_A = rig.CurrentsAtRest_A();
    if (!options.noise) {
      scan.field_sensor_T = rig.Readings(&truth, {});
      scan.saturated_mask = 0;
    }
    const tracker::Pose found = SolveCold(*solver, scan).pose;
    const Vector3d p = base::ToEigen(truth.centre_base_m);
    pairs.push_back({p, found.position_base_m - p});
    const double cosine = found.axis_base.dot(base::ToEigen(truth.axis_base));
    error.orientation_deg += kDegrees * std::acos(std::clamp(cosine, -1.0, 1.0)) / options.poses;
  }
  const Vector3d w = BestRotation(pairs);
  error.rotation_deg = kDegrees * w.norm();
  double square_mm2 = 0;
  for (const Pair& pair : pairs) {
    square_mm2 += 1e6 * pair.error.squaredNorm() / options.poses;
    error.raw_mm += 1e3 * pair.error.norm() / options.poses;
    error.aligned_mm += 1e3 * (pair.error - w.cross(pair.truth)).norm() / options.poses;
  }
  error.raw_rms_mm = std::sqrt(square_mm2);
  return error;
}

}  // namespace omni::test
