// A device's nominal geometry in the form of a calibration.
#pragma once

#include "service/base/calibration.h"
#include "service/base/device_geometry.h"

namespace omni::magnetics {

// Nominal sensors (unit gain), coils' fields from their windings and the core, no background. Allocates.
base::Calibration NominalCalibration(const base::DeviceGeometry& device);

}  // namespace omni::magnetics
