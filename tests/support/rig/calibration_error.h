// Error of poses with a calibration: static single scans of a simulated base, solved cold, compared with its truth.
#pragma once

#include <cstdint>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "tests/support/rig/rig.h"

namespace omni::test {

struct CalibrationError {
  double raw_mm = 0;      // mean |estimate - truth|, frame B
  double raw_rms_mm = 0;  // the same, rms
  double aligned_mm = 0;  // the same after removing the best common rotation about the core's centre
  double rotation_deg = 0;
  double orientation_deg = 0;  // mean angle between the axes
};

struct ErrorOptions {
  int poses = 1000;
  sim::PoseRange range;
  bool noise = true;   // of the rig; false: its field itself
  bool swept = false;  // the calibration's background is from a sweep of the base: Rig::CurrentsAtRest_A
  double model_error_relative = 2e-4;  // calibration error that the solver allows for, besides noise
  std::uint64_t seed = 1;
};

// Error: the solver rejects the calibration.
base::Result<CalibrationError> MeasureCalibrationError(sim::Rig& rig, const base::Calibration& calibration,
                                                       const ErrorOptions& options);

}  // namespace omni::test
