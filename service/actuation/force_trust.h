// How hard a base may be asked to push that is known only so well. Set-up only. docs/theory/actuation.md (15)
#pragma once

#include "service/actuation/force_map.h"
#include "service/base/calibration.h"
#include "service/base/device_geometry.h"

namespace omni::actuation {

// A pose of a base that nobody has calibrated is almost never further off: tests/loop/uncalibrated.cc.
inline constexpr double kDrawnError_m = 12e-3;

// The share of the greatest force, 0 to 1, that leaves the true force within it although the pen may touch the hull
// while it seems to be `position_error_m` away from it: what an ampere does there over what it does at the hull.
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device, double position_error_m) noexcept;

// As drawn, and as calibrated: with three times the error that the calibration says it leaves. One that says nothing
// counts as the drawing.
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device) noexcept;
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device,
                  const base::Calibration& calibration) noexcept;

}  // namespace omni::actuation
