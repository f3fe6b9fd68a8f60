#include "service/tools/track/track.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "service/base/eigen.h"
#include "service/tools/common/row_table.h"
#include "service/tracker/solve/static_solve.h"

namespace omni::tools {
namespace {

using base::Vec3;

constexpr std::size_t kRowsShown = 16;  // between two updates of the progress
constexpr double kSamePosition_m = 1e-5, kSameTurn_rad = 1e-2 * std::numbers::pi / 180;

double Angle_rad(const Vec3& a, const Vec3& b) {
  const Eigen::Vector3d u = base::ToEigen(a), v = base::ToEigen(b);
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

double Distance_m(const Vec3& a, const Vec3& b) { return (base::ToEigen(a) - base::ToEigen(b)).norm(); }

const char* NameOf(tracker::StaticStatus status) {
  switch (status) {
    case tracker::StaticStatus::kFound:
      return "found";
    case tracker::StaticStatus::kPoorFit:
      return "poor-fit";
    case tracker::StaticStatus::kNoFit:
      return "no-fit";
    case tracker::StaticStatus::kTooFew:
      break;
  }
  return "too-few";
}

TrackedPose Describe(const tracker::StaticPose& solved, std::size_t sensors) {
  TrackedPose pose;
  pose.status = NameOf(solved.status);
  pose.found = solved.status == tracker::StaticStatus::kFound || solved.status == tracker::StaticStatus::kPoorFit;
  pose.position_base_m = base::FromEigen(solved.pose.position_base_m);
  pose.axis_base = base::FromEigen(solved.pose.axis_base);
  std::copy_n(solved.covariance.data(), pose.covariance.size(), pose.covariance.begin());  // symmetric
  pose.chi2 = solved.chi2;
  pose.dof = solved.dof;
  pose.iterations = solved.iterations;
  double square = 0;
  int used = 0;
  for (std::size_t i = 0; i < sensors; ++i) {
    const double* r = &solved.residual_T[3 * i];
    pose.residual_sensor_T.push_back({r[0], r[1], r[2]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(r[axis])) continue;
      square += r[axis] * r[axis];
      ++used;
    }
  }
  pose.residual_rms_T = used > 0 ? std::sqrt(square / used) : 0;
  return pose;
}

std::vector<tracker::ArrayReading> ReadingsOf(const base::Calibration& array, const RecordedPose& pose) {
  std::vector<tracker::ArrayReading> readings;
  for (const Vec3& field : pose.field_sensor_T) {
    tracker::ArrayReading reading{.field_sensor_T = field};
    const std::array<double, 3> axes{field.x, field.y, field.z};
    for (std::size_t axis = 0; array.sensor_range_T > 0 && axis < 3; ++axis) {
      if (!(std::abs(axes[axis]) < array.sensor_range_T)) reading.saturated_axes |= 1U << axis;
    }
    readings.push_back(reading);
  }
  return readings;
}

class Accumulated {
 public:
  void Add(double distance_m, double turn_rad) {
    distance_mm_.push_back(1e3 * distance_m);
    turn_deg_.push_back(turn_rad * 180 / std::numbers::pi);
  }
  nlohmann::ordered_json Row(const char* start, std::size_t missing) const {
    return {{"start", start},
            {"n", distance_mm_.size()},
            {"without_answer", missing},
            {"mean_mm", Mean(distance_mm_)},
            {"median_mm", Quantile(distance_mm_, 0.5)},
            {"p95_mm", Quantile(distance_mm_, 0.95)},
            {"max_mm", Quantile(distance_mm_, 1)},
            {"orientation_mean_deg", Mean(turn_deg_)},
            {"orientation_median_deg", Quantile(turn_deg_, 0.5)},
            {"orientation_p95_deg", Quantile(turn_deg_, 0.95)},
            {"orientation_max_deg", Quantile(turn_deg_, 1)}};
  }

 private:
  std::vector<double> distance_mm_, turn_deg_;
};

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), ",%.9g", value);
  return text;
}

// Upper triangle, mm and rad.
std::string CovarianceText(const std::array<double, 25>& covariance) {
  std::string text;
  for (std::size_t row = 0; row < 5; ++row) {
    for (std::size_t column = row; column < 5; ++column) {
      const double scale = (row < 3 ? 1e3 : 1) * (column < 3 ? 1e3 : 1);
      text += Number(scale * covariance[5 * row + column]);
    }
  }
  return text;
}

std::string PoseText(const TrackedPose& pose) {
  const Vec3 &p = pose.position_base_m, &u = pose.axis_base;
  return Number(1e3 * p.x) + Number(1e3 * p.y) + Number(1e3 * p.z) + Number(u.x) + Number(u.y) + Number(u.z);
}

}  // namespace

base::Result<std::vector<TrackedRow>> TrackRecording(const base::Calibration& array, const Recording& recording,
                                                     const TrackOptions& options) {
  tracker::StaticOptions solve;
  solve.trust.currents_hidden = options.currents == TrackCurrents::kHidden;
  solve.chi2_max = options.chi2_max;
  const auto solver = tracker::StaticSolver::Make(array, solve);
  if (!solver.ok()) return base::Error{solver.error()};
  std::vector<TrackedRow> rows;
  std::optional<tracker::Pose> before;
  for (const RecordedPose& recorded : recording.poses) {
    const std::vector<tracker::ArrayReading> readings = ReadingsOf(array, recorded);
    const tracker::StaticPose cold = solver->Solve(readings, recorded.current_A);
    const tracker::StaticPose warm = before ? solver->Solve(readings, recorded.current_A, before) : cold;
    TrackedRow row{.number = recorded.number,
                   .cold = Describe(cold, array.sensors.size()),
                   .warm = Describe(warm, array.sensors.size())};
    row.same = row.cold.found && row.warm.found &&
               Distance_m(row.cold.position_base_m, row.warm.position_base_m) <= kSamePosition_m &&
               Angle_rad(row.cold.axis_base, row.warm.axis_base) <= kSameTurn_rad;
    before.reset();
    if (row.warm.found) before = warm.pose;
    rows.push_back(std::move(row));
    const bool shown = options.progress && rows.size() % kRowsShown == 0;
    if (shown && !options.progress(static_cast<double>(rows.size()) / static_cast<double>(recording.poses.size())))
      break;
  }
  return rows;
}

std::string WritePoses(const std::vector<TrackedRow>& rows) {
  std::string text = "pose,status,x_mm,y_mm,z_mm,ux,uy,uz";
  constexpr const char* kNames[] = {"x", "y", "z", "a", "b"};
  for (std::size_t row = 0; row < 5; ++row) {
    for (std::size_t column = row; column < 5; ++column) {
      const char* unit = column < 3 ? "_mm2" : row < 3 ? "_mm_rad" : "_rad2";
      text += std::string(",cov_") + kNames[row] + kNames[column] + unit;
    }
  }
  text += ",chi2,dof,iterations,residual_rms_uT,warm_x_mm,warm_y_mm,warm_z_mm,warm_ux,warm_uy,warm_uz,same\n";
  for (const TrackedRow& row : rows) {
    text += std::to_string(row.number) + "," + row.cold.status + PoseText(row.cold) +
            CovarianceText(row.cold.covariance) + Number(row.cold.chi2) + "," + std::to_string(row.cold.dof) + "," +
            std::to_string(row.cold.iterations) + Number(1e6 * row.cold.residual_rms_T) + PoseText(row.warm) +
            (row.same ? ",1\n" : ",0\n");
  }
  return text;
}

std::string WriteResiduals(const std::vector<TrackedRow>& rows) {
  std::string text = "pose,sensor,rx_uT,ry_uT,rz_uT\n";
  for (const TrackedRow& row : rows) {
    for (std::size_t i = 0; i < row.cold.residual_sensor_T.size(); ++i) {
      const Vec3& r = row.cold.residual_sensor_T[i];
      text += std::to_string(row.number) + "," + std::to_string(i) + Number(1e6 * r.x) + Number(1e6 * r.y) +
              Number(1e6 * r.z) + "\n";
    }
  }
  return text;
}

Rows TrackErrors(const std::vector<TrackedRow>& rows, const Truth& truth) {
  Accumulated cold, warm;
  std::size_t cold_missing = 0, warm_missing = 0;
  for (const TrackedRow& row : rows) {
    const auto known = truth.find(row.number);
    if (known == truth.end()) continue;
    const auto add = [&](const TrackedPose& pose, Accumulated& into, std::size_t& missing) {
      if (!pose.found) {
        ++missing;
        return;
      }
      into.Add(Distance_m(pose.position_base_m, known->second.position_base_m),
               Angle_rad(pose.axis_base, known->second.axis_base));
    };
    add(row.cold, cold, cold_missing);
    add(row.warm, warm, warm_missing);
  }
  return {cold.Row("cold", cold_missing), warm.Row("warm", warm_missing)};
}

}  // namespace omni::tools
