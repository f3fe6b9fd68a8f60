#include "service/calibration/checks/zero.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

#include "service/base/eigen.h"
#include "service/tracker/room/field_split.h"

namespace omni::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kMoved_T = 1e-6;      // from one quarter of a second to another
constexpr double kUniform_T = 1.5e-4;  // change of the field: twice the earth's, as when a base is turned over
constexpr double kUneven_T = 1.5e-5;   // rms of what is not uniform
constexpr double kGradient_T =
    5e-7;  // rms of what changes evenly over the base, as the field of something far does ...
constexpr double kGradientShare = 6;  // ... and so much above what the sensors have each for itself

template <class... Arguments>
std::string Words(const char* format, Arguments... arguments) {
  char text[320];
  std::snprintf(text, sizeof text, format, arguments...);
  return text;
}

// A uniform field at a sensor: with what the core makes of it.
Matrix3d UniformAt(const base::Calibration& calibration, const Vector3d& from_core_m) {
  const double share = calibration.core_radius_m / from_core_m.norm();
  const Vector3d n = from_core_m.normalized();
  return Matrix3d::Identity() +
         calibration.core_kappa * share * share * share * (3 * n * n.transpose() - Matrix3d::Identity());
}

}  // namespace

base::Result<Zeroed> Rezero(const base::Calibration& before,
                            const std::array<ZeroReadings, base::kSensorCount>& readings) {
  const auto refused = [](const std::string& why) { return base::Error{"not zeroed: " + why}; };
  Zeroed zeroed{.calibration = before};
  tracker::FieldShapes<0> shapes;
  tracker::ReadingLanes change_T{};
  for (std::size_t i = 0; i < readings.size(); ++i) {
    Vector3d mean = Vector3d::Zero();
    for (const base::Vec3& block : readings[i]) mean += base::ToEigen(block) / kZeroBlocks;
    for (const base::Vec3& block : readings[i]) {
      if (const double moved_T = (base::ToEigen(block) - mean).norm(); !(moved_T <= kMoved_T)) {
        return refused(
            Words("sensor %zu changed by %.1f uT meanwhile, the limit is %.0f: leave base, pen and magnets at rest", i,
                  1e6 * moved_T, 1e6 * kMoved_T));
      }
    }
    base::SensorCalibration& sensor = zeroed.calibration.sensors[i];
    const Eigen::Map<const RowMajor3d> gain(sensor.gain_sensor_base.data());
    const Vector3d from_core_m = base::ToEigen(sensor.position_base_m) - base::ToEigen(before.core_centre_base_m);
    const Vector3d changed_T = gain.inverse() * (mean - base::ToEigen(sensor.background_sensor_T));
    const Matrix3d uniform = UniformAt(before, from_core_m);
    shapes.SetFar(i, base::FromEigen(from_core_m));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t row = base::kSensorCount * axis + i;
      const auto at = static_cast<Eigen::Index>(axis);
      change_T[row] = changed_T[at];
      for (std::size_t k = 0; k < tracker::kUniformShapes; ++k) {
        shapes.rows[k][row] = uniform(at, static_cast<Eigen::Index>(k));
      }
    }
    sensor.background_sensor_T = base::FromEigen(mean);
  }
  tracker::FieldSplit<0> split;
  if (!tracker::SplitField(shapes, change_T, split)) return refused("a reading is not a number");
  zeroed.uniform_T = std::hypot(split.sizes[0], split.sizes[1], split.sizes[2]);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const auto& rest_T = split.rest_T;
    zeroed.own_T = std::max(zeroed.own_T,
                            std::hypot(rest_T[i], rest_T[base::kSensorCount + i], rest_T[2 * base::kSensorCount + i]));
  }
  if (!(zeroed.uniform_T <= kUniform_T)) {
    return refused(
        Words("the field around the base has changed by %.0f uT, the limit is %.0f: a strong magnet is near; "
              "take it away, or calibrate this base again: omni calibrate --replace",
              1e6 * zeroed.uniform_T, 1e6 * kUniform_T));
  }
  const bool from_far = std::sqrt(split.gradient_T2) > kGradient_T && split.gradient > kGradientShare;
  const double uneven_T = std::sqrt(split.rest_T2);
  if (from_far || !(uneven_T <= kUneven_T)) {
    return refused(
        Words("the field is uneven by %.1f uT since this base was calibrated: the pen, another magnet or iron "
              "is near; take it away, or, if it stays there, calibrate this base again: omni calibrate "
              "--replace",
              1e6 * uneven_T));
  }
  return zeroed;
}

}  // namespace omni::calibration
