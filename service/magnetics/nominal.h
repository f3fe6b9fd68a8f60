// Quantities computed from a device's geometry, in the form of a calibration. Set-up only: allocates.
#pragma once

#include <vector>

#include "service/base/device_geometry.h"

namespace omni::magnetics {

// Br V / mu0. docs/theory/magnetics.md (8)
double MomentOf(const base::MagnetGeometry& magnet) noexcept;

// Current maps of three windings about the core of `array`, in the sensors' own frames and gains, core included.
// Precondition: none or base::kCoilCount coils (none: maps stay).
void AddWindings(const std::vector<base::CoilGeometry>& coils, base::Calibration& array);

// Nominal sensors (unit gain), coils' fields from their windings and the core, no background. Allocates.
base::Calibration NominalCalibration(const base::DeviceGeometry& device);

}  // namespace omni::magnetics
