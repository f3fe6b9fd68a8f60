// Static scans through the product's tracker, or through its static solver with a given trust, compared with the truth.
#pragma once

#include <array>

#include "service/base/eigen.h"
#include "service/base/hall_scan.h"
#include "service/base/tool_state.h"
#include "service/tracker/solve/static_solve.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/errors.h"

namespace omni::bench {

inline tracker::StaticPose SolveScan(const tracker::StaticSolver& solver, const base::HallScan& scan,
                                     const std::optional<tracker::Pose>& start = std::nullopt) {
  std::array<tracker::ArrayReading, base::kSensorCount> readings;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    readings[i] = {scan.field_sensor_T[i], (scan.saturated_mask >> (3 * i)) & 7U};
  }
  return solver.Solve(readings, scan.coil_current_A, start);
}

inline bool HasPose(const tracker::StaticPose& solved) noexcept {
  return solved.status == tracker::StaticStatus::kFound || solved.status == tracker::StaticStatus::kPoorFit;
}

// One scan alone, as omnid's first scan of a pen since `state`. kNoFit: not tracked.
inline tracker::StaticPose TrackScan(const tracker::Config& config, const base::HallScan& scan,
                                     tracker::State state = {}) {
  base::ToolState tool;
  tracker::Update(config, scan, state, tool);
  tracker::StaticPose pose;
  if (tool.status != base::TrackingStatus::kTracking) return pose;
  pose.status = tracker::StaticStatus::kFound;
  pose.pose = {base::ToEigen(tool.position_base_m), base::ToEigen(tool.axis_base)};
  pose.covariance = Eigen::Map<const Eigen::Matrix<double, 5, 5, Eigen::RowMajor>>(tool.covariance.data());
  return pose;
}

inline PoseError ErrorOf(const sim::MagnetPose& truth, const tracker::Pose& pose) noexcept {
  return ErrorOf(truth, base::FromEigen(pose.position_base_m), base::FromEigen(pose.axis_base));
}

// A poor fit counts as well: leaving it out would flatter the result.
inline void AddSolved(const sim::MagnetPose& truth, const tracker::StaticPose& solved, ErrorSet& errors) {
  if (HasPose(solved)) {
    errors.Add(ErrorOf(truth, solved.pose));
  } else {
    errors.AddMissing();
  }
}

}  // namespace omni::bench
