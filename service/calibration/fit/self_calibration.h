// Self-calibration: from "sweep the coils, wave the pen for 20 s, touch the hull in 100 places" to a Calibration. No
// true pose is needed. Set-up only: allocates, takes about a second. docs/theory/calibration.md
#pragma once

#include <span>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/calibration/types.h"

namespace omni::calibration {

struct Outcome {
  base::Calibration calibration;
  Report report;
};

// `nominal`: the nominal array (magnetics::NominalCalibration, or any other); its sensor_noise_T is that of
// Sample::noise_scale = 1. `coils`: nominal, in the order of the current maps; empty: none, or not to be used. Rejects
// a recording that would make a bad calibration, with the reason.
base::Result<Outcome> SelfCalibrate(const base::Calibration& nominal, std::span<const base::CoilGeometry> coils,
                                    const Recording& recording, const Options& options = {});

}  // namespace omni::calibration
