// Reads the CSV files of a public family of recordings (16 magnetometers on a patch, optical truth; see
// docs/howto/track.md for where they come from and what the columns mean).
#pragma once

#include <string>

#include "service/base/calibration.h"
#include "service/base/result.h"
#include "service/tools/track/track_recording.h"

namespace omni::tools {

struct Magnet16Options {
  double magnet_diameter_m = 10e-3;
  double magnet_height_m = 10e-3;
  double noise_T = 5e-6;  // the files do not say; equal for all axes, so that it weighs no reading above another
};

// layout-N.csv: sensor, x_mm, y_mm, z_mm, rotvec_x, rotvec_y, rotvec_z, magnetization_A_per_m, ambient_x_uT,
// ambient_y_uT, ambient_z_uT. The magnetisation that a sensor sees absorbs its gain: moment = mean magnetisation times
// volume, gain = the sensor's share of the mean.
base::Result<base::Calibration> ReadMagnet16Layout(const std::string& path, const Magnet16Options& options);

}  // namespace omni::tools
