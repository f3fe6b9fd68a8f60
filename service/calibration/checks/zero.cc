#include "service/calibration/checks/zero.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

#include "service/base/eigen.h"

namespace omni::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
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

// Fields without sources that change evenly: five of them, r = (x, y, z).
Eigen::Matrix<double, 3, 5> GradientAt(const Vector3d& r) {
  Eigen::Matrix<double, 3, 5> fields;
  fields << r.x(), 0, r.y(), r.z(), 0,  //
      -r.y(), r.y(), r.x(), 0, r.z(),   //
      0, -r.z(), 0, r.x(), r.y();
  return fields;
}

// The rest of `change`, frame B, after subtracting the best of these fields.
VectorXd Without(const MatrixXd& fields, const VectorXd& change) {
  return change - fields * fields.colPivHouseholderQr().solve(change);
}

double Rms(double square, Eigen::Index count) { return std::sqrt(square / static_cast<double>(count)); }

}  // namespace

base::Result<Zeroed> Rezero(const base::Calibration& before,
                            const std::array<ZeroReadings, base::kSensorCount>& readings) {
  const auto refused = [](const std::string& why) { return base::Error{"not zeroed: " + why}; };
  Zeroed zeroed{.calibration = before};
  const auto rows = static_cast<Eigen::Index>(3 * readings.size());
  VectorXd change(rows);
  MatrixXd fields(rows, 8);
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
    const auto at = static_cast<Eigen::Index>(3 * i);
    const Eigen::Map<const RowMajor3d> gain(sensor.gain_sensor_base.data());
    const Vector3d from_core_m = base::ToEigen(sensor.position_base_m) - base::ToEigen(before.core_centre_base_m);
    change.segment<3>(at) = gain.inverse() * (mean - base::ToEigen(sensor.background_sensor_T));
    fields.block<3, 3>(at, 0) = UniformAt(before, from_core_m);
    fields.block<3, 5>(at, 3) = GradientAt(from_core_m);
    sensor.background_sensor_T = base::FromEigen(mean);
  }
  const MatrixXd uniform = fields.leftCols<3>();
  const VectorXd uneven = Without(uniform, change), own = Without(fields, change);
  zeroed.uniform_T = uniform.colPivHouseholderQr().solve(change).norm();
  for (Eigen::Index at = 0; at < rows; at += 3) zeroed.own_T = std::max(zeroed.own_T, uneven.segment<3>(at).norm());
  if (!(zeroed.uniform_T <= kUniform_T)) {
    return refused(
        Words("the field around the base has changed by %.0f uT, the limit is %.0f: a strong magnet is near; "
              "take it away, or calibrate this base again: omni calibrate --replace",
              1e6 * zeroed.uniform_T, 1e6 * kUniform_T));
  }
  const double gradient = uneven.squaredNorm() - own.squaredNorm();
  const double share = gradient / 5 / (own.squaredNorm() / static_cast<double>(rows - 8));
  const bool from_far = Rms(gradient, rows) > kGradient_T && share > kGradientShare;
  if (from_far || !(Rms(uneven.squaredNorm(), rows) <= kUneven_T)) {
    return refused(
        Words("the field is uneven by %.1f uT since this base was calibrated: the pen, another magnet or iron "
              "is near; take it away, or, if it stays there, calibrate this base again: omni calibrate "
              "--replace",
              1e6 * Rms(uneven.squaredNorm(), rows)));
  }
  return zeroed;
}

}  // namespace omni::calibration
