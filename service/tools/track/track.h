// Parts of `omni track`: a recording of an array, and the tracker run over it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/tools/common/row_table.h"

namespace omni::tools {

// A recording of an array: readings pose by pose, and the true pose where it was measured.
// Formats: docs/howto/track.md.

// No magnet of the allowed kind makes more at a sensor outside it; uT written as T does.
constexpr double kFieldMax_T = 2;

struct RecordedPose {
  std::size_t number = 0;                  // as in the file
  std::vector<base::Vec3> field_sensor_T;  // by sensor, background included
  std::array<double, base::kCoilCount> current_A{};
};

struct Recording {
  std::vector<RecordedPose> poses;  // in the file's order
  bool has_currents = false;
};

struct TruePose {
  base::Vec3 position_base_m;
  base::Vec3 axis_base;  // unit, along the moment
};
using Truth = std::map<std::size_t, TruePose>;  // by number

// pose, sensor, bx_U, by_U, bz_U (U: T, mT, uT, G or mG); optional i0_A, i1_A, i2_A. Every pose has every one of the
// `array`'s sensors once.
base::Result<Recording> ReadRecording(const std::string& path, const base::Calibration& array);

// pose, x_U, y_U, z_U (U: m or mm), ux, uy, uz.
base::Result<Truth> ReadTruth(const std::string& path);

std::string WriteRecording(const Recording& recording);
std::string WriteTruth(const Truth& truth);

// Any device file as what the tracker needs: an array file, or the geometry of an Omni base.
base::Result<base::Calibration> LoadTrackDevice(const std::string& path);

// Reads the CSV files of a public family of recordings (16 magnetometers on a patch, optical truth; see
// docs/howto/track.md for where they come from and what the columns mean).
struct Magnet16Options {
  double magnet_diameter_m = 10e-3;
  double magnet_height_m = 10e-3;
  double noise_T = 5e-6;  // the files do not say; equal for all axes, so that it weighs no reading above another
};

// layout-N.csv: sensor, x_mm, y_mm, z_mm, rotvec_x, rotvec_y, rotvec_z, magnetization_A_per_m, ambient_x_uT,
// ambient_y_uT, ambient_z_uT. The magnetisation that a sensor sees absorbs its gain: moment = mean magnetisation times
// volume, gain = the sensor's share of the mean.
base::Result<base::Calibration> ReadMagnet16Layout(const std::string& path, const Magnet16Options& options);

// Tracks a recording pose by pose: each row with a cold start, and again with a warm start from the row before.

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
