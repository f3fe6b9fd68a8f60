#include "service/calibration/start.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/tracker/cold_start.h"
#include "service/tracker/measurement.h"
#include "service/tracker/model.h"
#include "service/tracker/solver.h"

namespace omni::calibration {
namespace {

constexpr double kDamping = 1e-2;
constexpr int kIterationsMax = 40;
constexpr double kChi2PerDofMax = 9;  // three standard deviations of tolerance on every reading at once

// How far a reading may be off before calibration, relative to the tool's field: a displacement d of a sensor at
// distance L changes a dipole's field by 3 d/L.
double ToleranceOfField(const base::Calibration& nominal, const Tolerances& t) {
  double square_m2 = 0;
  for (const base::SensorCalibration& sensor : nominal.sensors) {
    square_m2 += base::ToEigen(sensor.position_base_m).squaredNorm() / static_cast<double>(nominal.sensors.size());
  }
  const double displacement = 3 * t.sensor_position_m / std::sqrt(std::max(square_m2, 1e-4));
  return std::sqrt(displacement * displacement + t.sensor_gain * t.sensor_gain +
                   t.sensor_rotation_rad * t.sensor_rotation_rad + t.moment * t.moment);
}

base::HallScan ToScan(const Sample& sample) {
  base::HallScan scan;
  scan.fresh_mask = (1U << base::kSensorCount) - 1;
  std::copy_n(sample.field_sensor_T.begin(), base::kSensorCount, scan.field_sensor_T.begin());
  scan.coil_current_A = sample.coil_current_A;
  return scan;
}

}  // namespace

std::vector<ColdPose> ColdPoses(const base::Calibration& nominal, const Recording& recording,
                                const Tolerances& tolerances) {
  const tracker::Model model = tracker::MakeModel(nominal);
  tracker::Trust trust;
  trust.model_error_relative = ToleranceOfField(nominal, tolerances);
  std::vector<ColdPose> poses;
  for (const Sample& sample : recording.samples) {
    const base::HallScan scan = ToScan(sample);
    const tracker::Measurement measurement =
        tracker::MakeMeasurement(model, trust, scan, {}, tracker::Remember(scan, {}));
    ColdPose best;
    double best_chi2 = kChi2PerDofMax * std::max(0, measurement.axes - tracker::kParameters);
    const tracker::ColdCandidates candidates = tracker::RankGrid(model, measurement);
    for (int c = 0; c < candidates.count; ++c) {
      const tracker::Fit fit = tracker::SolvePose(model, measurement, candidates.poses[static_cast<std::size_t>(c)],
                                                  kDamping, kIterationsMax);
      if (!(fit.chi2 < best_chi2 && fit.pose.position_base_m.allFinite())) continue;
      best_chi2 = fit.chi2;
      best = {true, fit.pose.position_base_m, fit.pose.axis_base};
    }
    poses.push_back(best);
  }
  return poses;
}

}  // namespace omni::calibration
