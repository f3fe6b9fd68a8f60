// Tracks a recording pose by pose: each row with a cold start, and again with a warm start from the row before.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "service/base/calibration.h"
#include "service/base/result.h"
#include "service/tools/common/row_table.h"
#include "service/tools/track/track_recording.h"

namespace omni::tools {

// What is known of the coil currents while a row was read.
enum class TrackCurrents { kMeasured, kHidden };

struct TrackOptions {
  TrackCurrents currents = TrackCurrents::kMeasured;
  double chi2_max = 80;                       // gate at 19 degrees of freedom, scaled to others
  std::function<bool(double done)> progress;  // called now and then with 0 ... 1; false: no further row
};

struct TrackedPose {
  const char* status = "";  // found, poor-fit, no-fit, too-few
  bool found = false;       // a pose is there (found or poor-fit)
  base::Vec3 position_base_m;
  base::Vec3 axis_base;
  std::array<double, 25> covariance{};  // (position in m, turns along two tangents of the axis in rad), row-major
  double chi2 = 0;
  int dof = 0;
  int iterations = 0;
  std::vector<base::Vec3> residual_sensor_T;  // reading minus model; NaN: axis not used
  double residual_rms_T = 0;
};

struct TrackedRow {
  std::size_t number = 0;
  TrackedPose cold, warm;
  bool same = false;  // both within 0.01 mm and 0.01 deg of each other
};

base::Result<std::vector<TrackedRow>> TrackRecording(const base::Calibration& array, const Recording& recording,
                                                     const TrackOptions& options);

// One line per pose: the cold solution with its covariance and residuals, and the warm one's pose.
std::string WritePoses(const std::vector<TrackedRow>& rows);

// One line per pose and sensor: residuals of the cold solution.
std::string WriteResiduals(const std::vector<TrackedRow>& rows);

// Errors against the truth, one row per kind of start: start, n, mean_mm, median_mm, p95_mm, max_mm,
// orientation_mean_deg, ... Poses without a solution are counted, not averaged; poses that the truth lacks are ignored.
Rows TrackErrors(const std::vector<TrackedRow>& rows, const Truth& truth);

}  // namespace omni::tools
