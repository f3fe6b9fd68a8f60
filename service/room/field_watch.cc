#include "service/room/field_watch.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "service/base/eigen.h"
#include "service/tracker/room/field_split.h"

namespace omni::room {
namespace {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kModelError = 0.02;    // of the field of a pen that lies far away
constexpr double kPenAmbient_T = 1e-5;  // beside it
constexpr int kSensorsMin = 4;

std::string Microtesla(double field_T) { return std::to_string(std::lround(1e6 * field_T)) + " uT"; }

tracker::StaticOptions PenOptions() {
  tracker::StaticOptions options;
  options.trust.model_error_relative = kModelError;
  options.trust.ambient_error_T = kPenAmbient_T;
  return options;
}

RoomFinding MagnetNear() {
  return {.kind = "magnet-near",
          .sensors = {},
          .what = "another magnet is near (a second pen, a phone, a loudspeaker)",
          .fix = "take it away"};
}

RoomFinding SteelNear() {
  return {.kind = "steel-near",
          .sensors = {},
          .what =
              "steel is near that was not there when the base was calibrated (a desk that was raised, a laptop), or a "
              "moving magnet",
          .fix = "take it away; if it must stay: omni calibrate --replace"};
}

RoomFinding FieldChanged(double field_T) {
  return {.kind = "field-changed",
          .sensors = {},
          .what = "the field around the base has changed since its calibration by " + Microtesla(field_T) +
                  ": it was carried or turned, or much iron was moved",
          .fix = "take the pen away, then: omni calibrate --zero"};
}

RoomFinding UnevenChanged() {
  return {
      .kind = "field-uneven",
      .sensors = {},
      .what =
          "the field around the base has changed since its calibration, and not equally at all sensors: a magnet, a "
          "laptop or steel came near, or its sensors drifted",
      .fix = "take it away; if it must stay, take the pen away, then: omni calibrate --zero"};
}

}  // namespace

FieldWatch::FieldWatch(const base::Calibration& calibration) : calibration_(calibration) {
  auto solver = tracker::StaticSolver::Make(calibration, PenOptions());
  if (solver.ok()) solver_.emplace(std::move(*solver));
  for (const base::SensorCalibration& sensor : calibration_.sensors) {
    const RowMajor3d gain = Eigen::Map<const RowMajor3d>(sensor.gain_sensor_base.data());
    calibrated_T_ += gain.inverse() * base::ToEigen(sensor.background_sensor_T) / base::kSensorCount;
  }
}

void FieldWatch::Add(const tracker::RoomSample& sample) {
  const base::ToolState& tool = sample.tool;
  ++second_.samples;
  if (tool.status == base::TrackingStatus::kTracking) {
    const Vector3d ambient_T = base::ToEigen(tool.ambient_base_T);
    ++second_.tracked;
    second_.stray += tool.stray_rms_T > 0 ? 1 : 0;
    second_.ambient_sum_T += ambient_T;
    second_.ambient_square_T2 += ambient_T.squaredNorm();
  } else if (tool.status == base::TrackingStatus::kAbsent && tool.field_rms_T < tracker::kMagnetNear_T) {
    ++second_.quiet;
    for (int i = 0; i < base::kSensorCount; ++i) {
      second_.reading_sum_T.col(i) += base::ToEigen(sample.scan.field_sensor_T[static_cast<std::size_t>(i)]);
    }
    second_.current_sum_A += Vector3d(sample.scan.coil_current_A.data());
  }
}

void FieldWatch::EndSecond(std::uint32_t useless, bool contradicted) {
  field_T_.reset();
  if (contradicted) {
    if (has_fitted_) is_magnet_.Add(true);  // a calibration that fitted still fits: something new is near
  } else if (IsMostly(second_.tracked, second_.samples)) {
    has_fitted_ = true;
    JudgeTracked();
  }
  if (IsMostly(second_.quiet, second_.samples)) JudgeResting(useless);
  second_ = {};
}

// An uneven field may be a magnet's, which stays, or the response of steel to the pen, which moves with it.
void FieldWatch::JudgeTracked() {
  const double n = second_.tracked;
  const Vector3d ambient_T = second_.ambient_sum_T / n;
  const double spread_T = std::sqrt(std::max(0.0, second_.ambient_square_T2 / n - ambient_T.squaredNorm()));
  const bool stray = IsMostly(second_.stray, second_.tracked);
  is_magnet_.Add(stray);
  wanders_.Add(stray && spread_T > kWanders_T);
  is_uniform_.Add(ambient_T.norm() > (is_uniform_.holds() ? kSteady_T : kUniform_T));
  is_uneven_.Add(false);
  if (!stray) field_T_ = calibrated_T_ + ambient_T;
  if (ambient_T.norm() > kSteady_T) uniform_T_ = ambient_T.norm();
}

void FieldWatch::JudgeResting(std::uint32_t useless) {
  const Fields reading_T = second_.reading_sum_T / second_.quiet;
  const Vector3d current_A = second_.current_sum_A / second_.quiet;
  tracker::FieldShapes<0> shapes;
  tracker::ReadingLanes field_T{};
  shapes.rows = {};
  shapes.readings = 0;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    if (((useless >> i) & 1u) != 0 || !reading_T.col(column).allFinite()) continue;
    const base::SensorCalibration& sensor = calibration_.sensors[i];
    const Vector3d expected_T = Eigen::Map<const RowMajor3d>(sensor.current_map_T_A.data()) * current_A +
                                base::ToEigen(sensor.background_sensor_T);
    const RowMajor3d gain = Eigen::Map<const RowMajor3d>(sensor.gain_sensor_base.data());
    const Vector3d changed_T = gain.inverse() * (reading_T.col(column) - expected_T);
    const Vector3d from_core_m = base::ToEigen(sensor.position_base_m) - base::ToEigen(calibration_.core_centre_base_m);
    shapes.SetFar(i, base::FromEigen(from_core_m));
    shapes.readings += 3;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      field_T[base::kSensorCount * axis + i] = changed_T[static_cast<Eigen::Index>(axis)];
    }
  }
  tracker::FieldSplit<0> split;
  if (shapes.readings < 3 * kSensorsMin || !tracker::SplitField(shapes, field_T, split)) return;
  const Vector3d uniform_T(split.sizes.data());
  const double uneven_T = std::sqrt(split.rest_T2);
  const bool even = uneven_T < std::max(kEven * uniform_T.norm(), kUneven_T);
  const bool from_afar = uneven_T < kEven * uniform_T.norm();
  if (even) field_T_ = calibrated_T_ + uniform_T;
  is_magnet_.Add(false);
  wanders_.Add(false);
  is_uniform_.Add(from_afar && uniform_T.norm() > (is_uniform_.holds() ? kSteady_T : kUniform_T));
  is_uneven_.Add(!even && !IsPen(reading_T, current_A, useless));
  if (from_afar && uniform_T.norm() > kSteady_T) uniform_T_ = uniform_T.norm();
}

bool FieldWatch::IsPen(const Fields& reading_T, const Vector3d& current_A, std::uint32_t useless) const {
  if (!solver_) return true;
  std::array<tracker::ArrayReading, base::kSensorCount> readings;
  for (int i = 0; i < base::kSensorCount; ++i) {
    auto& reading = readings[static_cast<std::size_t>(i)];
    reading.field_sensor_T = base::FromEigen(Vector3d(reading_T.col(i)));
    if (((useless >> i) & 1u) != 0) reading.field_sensor_T.x = std::nan("");
  }
  const auto pose = solver_->Solve(readings, {current_A.x(), current_A.y(), current_A.z()});
  return pose.status == tracker::StaticStatus::kFound;
}

void FieldWatch::Report(std::vector<RoomFinding>& findings) const {
  if (is_magnet_.holds()) return findings.push_back(wanders_.holds() ? SteelNear() : MagnetNear());
  if (is_uniform_.holds()) findings.push_back(FieldChanged(uniform_T_));
  if (is_uneven_.holds()) findings.push_back(UnevenChanged());
}

}  // namespace omni::room
