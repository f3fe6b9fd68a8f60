// What a calibration says about itself. SI.
#pragma once

#include <string>
#include <vector>

#include "service/base/calibration.h"

namespace omni::calibration {

struct SensorReport {
  double residual_T = 0;  // rms of its readings
  double chi2_per_reading = 0;
  double moved_m = 0;  // from the drawing
};

// A parameter that the recording did not determine: its uncertainty is mostly its tolerance.
struct Undetermined {
  std::string name;
  double sigma = 0;      // known to this, in `unit` ...
  double tolerance = 0;  // ... and before the recording to this
  std::string unit;
};

struct Report {
  int samples = 0;
  int touches = 0;
  int rests_in_air = 0;  // near the hull: taken for touches at first
  int rejected = 0;      // samples that fit no pose, or lost most of their weight
  double coverage = 0;   // of the upper hemisphere
  double chi2_per_dof = 0;
  int dof = 0;
  std::vector<SensorReport> sensors;
  double touch_rms_m = 0;
  double map_chi2_per_reading = 0;  // coils' shape against measured maps
  double moment_relative = 0;       // against the drawing
  double moment_sigma = 0;          // relative
  double moment_drift = 0;          // relative, over half the recording
  double frame_rotation_rad = 0;    // how well the frame's rotation about the core is known, per axis
  base::SteelPlane steel;           // under the base; strength 0: none was seen
  double expected_error_m = 0;      // rms position error that this calibration leaves, noise apart
  int weak_directions = 0;          // combinations of unknowns of which the tolerances say more than the recording
  std::vector<Undetermined> unfixed;
  int iterations = 0;
  double seconds = 0;
};

}  // namespace omni::calibration
