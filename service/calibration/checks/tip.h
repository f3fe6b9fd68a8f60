// Where the pen's tip is along its axis, from poses of a pen that is swung about it. docs/theory/calibration.md (7.1)
#pragma once

#include <span>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::calibration {

struct PivotPose {
  base::Vec3 position_base_m;  // of the magnet's centre
  base::Vec3 axis_base;        // means of both over the same instants do as well, whatever their length
};

struct Tip {
  double tip_offset_m = 0;
  double sigma_m = 0;    // its standard deviation
  double rms_m = 0;      // distance of the tip from its mean place, over the poses
  double swing_rad = 0;  // rms angle of the axis from its mean direction
};

// `drawn_m`: the drawing's; `expected_error_m`: of the calibration that the poses come from. Refuses, with the reason,
// a pen that was not swung enough, a tip that moved and one that is nowhere near the drawing's.
base::Result<Tip> FindTip(std::span<const PivotPose> poses, double drawn_m, double expected_error_m);

}  // namespace omni::calibration
