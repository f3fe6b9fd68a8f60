#include "service/calibration/fit/start.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"

namespace omni::calibration {
namespace {

constexpr double kChi2Max = 171;  // at 19 degrees of freedom: three standard deviations of tolerance on every reading

constexpr double kAmbient_T =
    2e-5;  // a steel desk responds to the pen with a field that is almost the same all over the base

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

}  // namespace

base::Result<ColdStart> ColdStart::Make(const base::Calibration& nominal, const Tolerances& tolerances) {
  tracker::StaticOptions options;
  options.trust.model_error_relative = ToleranceOfField(nominal, tolerances);
  options.trust.ambient_error_T = kAmbient_T;
  options.chi2_max = kChi2Max;
  auto solver = tracker::StaticSolver::Make(nominal, options);
  if (!solver.ok()) return base::Error{solver.error()};
  return ColdStart(std::move(*solver));
}

ColdPose ColdStart::FindPose(const Sample& sample) const {
  std::vector<tracker::ArrayReading> readings;
  readings.reserve(sample.field_sensor_T.size());
  for (const base::Vec3& field_T : sample.field_sensor_T) readings.push_back({field_T, 0});
  const tracker::StaticPose solved = solver_.Solve(readings, sample.coil_current_A);
  if (solved.status != tracker::StaticStatus::kFound || !solved.pose.position_base_m.allFinite()) return {};
  return {true, solved.pose.position_base_m, solved.pose.axis_base};
}

}  // namespace omni::calibration
