#include "service/tools/calibration_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "service/base/eigen.h"
#include "service/tracker/cold_start.h"
#include "service/tracker/measurement.h"
#include "service/tracker/solver.h"

namespace omni::tools {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegrees = 57.29577951308232;
constexpr double kDamping = 1e-2;
constexpr int kIterationsMax = 40;

// The best fit of all cold starts.
tracker::Pose SolveCold(const tracker::Model& model, const tracker::Trust& trust, const base::HallScan& scan) {
  const tracker::Measurement measurement =
      tracker::MakeMeasurement(model, trust, scan, {}, tracker::Remember(scan, {}));
  const tracker::ColdCandidates candidates = tracker::RankGrid(model, measurement);
  tracker::Pose best;
  double least = std::numeric_limits<double>::infinity();
  for (int c = 0; c < candidates.count; ++c) {
    const tracker::Fit fit =
        tracker::SolvePose(model, measurement, candidates.poses[static_cast<std::size_t>(c)], kDamping, kIterationsMax);
    if (!(fit.chi2 < least)) continue;
    least = fit.chi2;
    best = fit.pose;
  }
  return best;
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

CalibrationError MeasureCalibrationError(sim::Rig& rig, const base::Calibration& calibration,
                                         const ErrorOptions& options) {
  const tracker::Model model = tracker::MakeModel(calibration);
  tracker::Trust trust;
  trust.model_error_relative = options.model_error_relative;
  sim::Random random(options.seed);
  std::vector<Pair> pairs;
  CalibrationError error;
  for (int n = 0; n < options.poses; ++n) {
    const sim::MagnetPose truth = rig.DrawPose(options.range, random);
    base::HallScan scan = rig.Scan(&truth, {}, random);
    if (!options.noise) {
      scan.field_sensor_T = rig.Readings(&truth, {});
      scan.saturated_mask = 0;
    }
    const tracker::Pose found = SolveCold(model, trust, scan);
    const Vector3d p = base::ToEigen(truth.centre_base_m);
    pairs.push_back({p, found.position_base_m - p});
    const double cosine = found.axis_base.dot(base::ToEigen(truth.axis_base));
    error.orientation_deg += kDegrees * std::acos(std::clamp(cosine, -1.0, 1.0)) / options.poses;
  }
  const Vector3d w = BestRotation(pairs);
  error.rotation_deg = kDegrees * w.norm();
  for (const Pair& pair : pairs) {
    error.raw_mm += 1e3 * pair.error.norm() / options.poses;
    error.aligned_mm += 1e3 * (pair.error - w.cross(pair.truth)).norm() / options.poses;
  }
  return error;
}

}  // namespace omni::tools
