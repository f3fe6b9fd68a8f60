// What the drawing says about a device, in the form that calibration would give it.
#pragma once

#include "service/base/calibration.h"
#include "service/base/device_geometry.h"

namespace omni::magnetics {

// Sensors as drawn (unit gain), coils' fields from their windings and the core, no background. Allocates.
base::Calibration NominalCalibration(const base::DeviceGeometry& device);

}  // namespace omni::magnetics
