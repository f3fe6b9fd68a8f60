// How much force may be requested of a base of limited accuracy. Set-up only. docs/theory/actuation.md (7.1)
#pragma once

#include "service/actuation/force_map.h"
#include "service/base/calibration.h"
#include "service/base/device_geometry.h"

namespace omni::actuation {

// Poses of an uncalibrated base are almost never further off: tests/loop/uncalibrated.cc.
inline constexpr double kDrawnError_m = 12e-3;

// The share of the greatest force, 0 to 1, that keeps the true force within it although the pen may touch the hull
// while it seems to be `position_error_m` away from it: force per ampere there over that at the hull.
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device, double position_error_m) noexcept;

// For the nominal base, and for a calibrated one: with three times the error that the calibration states. One that
// states none counts as nominal.
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device) noexcept;
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device,
                  const base::Calibration& calibration) noexcept;

}  // namespace omni::actuation
