// The whole of a calibration on the twin in virtual time, a scripted hand doing what the person would (a simulation).
// The base is that of a sim::Rig with the same seed and imperfections.
#pragma once

#include <cstdint>

#include <functional>
#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/base/truth_parameters.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/tools/calibrate/calibrate_session.h"

namespace omni::tools {

// Sees the session after every scan.
using SessionObserver = std::function<void(const CalibrationSession&)>;

struct TwinCalibration {
  calibration::Outcome outcome;
  double middle_s = 0;  // of the recording, since the twin's start: the moment is that of this time
};

// `device`: its sensor_noise_T is the twin's. `observer` sees the session after every scan.
base::Result<TwinCalibration> CalibrateTwin(const base::DeviceGeometry& device, std::uint64_t seed,
                                            const base::TruthParameters& truth, const SessionOptions& options = {},
                                            const SessionObserver& observer = {});

// The nominal geometry with the tip of the pen that the twin's hand holds: the hand knows its own pen.
base::DeviceGeometry WithHeldTip(const base::DeviceGeometry& device, std::uint64_t seed,
                                 const base::TruthParameters& truth);

}  // namespace omni::tools
