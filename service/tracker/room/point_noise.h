// The noise of a tracked point as it enters a force. docs/theory/haptics.md, section 3
#pragma once

#include "service/base/tool_state.h"
#include "service/tracker/filter/filter.h"

namespace omni::tracker {

// In the worst direction; of a point `offset_m` along the axis from the magnet's centre.
base::PointNoise NoiseOfPoint(const FilterState& filter, double offset_m) noexcept;

// Along the axis, where a small tilt moves nothing.
base::PointNoise NoiseAlong(const FilterState& filter) noexcept;

}  // namespace omni::tracker
