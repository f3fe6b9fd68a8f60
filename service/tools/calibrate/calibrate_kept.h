// Calibrations as files: those that `omni calibrate` writes, and cached ones of simulated bases.
#pragma once

#include <cstdint>
#include <string>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/config/files/calibration_file.h"

namespace omni::tools {

// With today's date.
config::CalibrationFile CalibrationFileOf(const calibration::Outcome& outcome, const std::string& serial);

// Of the twin (a simulation) with this seed and these parameters, as config::FindTwin takes them: the one that Omni
// ships, else from the cache folder, or measured as `omni calibrate` does (half a minute) and cached there.
base::Result<base::Calibration> KeptTwinCalibration(const base::DeviceGeometry& device, std::uint64_t seed,
                                                    const std::string& twin);

}  // namespace omni::tools
