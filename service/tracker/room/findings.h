// Reports what the tracker found to be wrong together with the pose. docs/theory/tracking.md, Doubt
#pragma once

#include "service/base/tool_state.h"
#include "service/tracker/tracker.h"

namespace omni::tracker {

// frozen: every sensor repeats itself. Call after the scan's pose is in `tool`.
void ReportFindings(const RoomState& room, bool frozen, base::ToolState& tool) noexcept;

}  // namespace omni::tracker
