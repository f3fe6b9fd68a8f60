// Third stage: the pose that explains a scan, and under which assumption.
#pragma once

#include "service/tracker/stages/hypothesis.h"

namespace omni::tracker {

// outcome.good: found, and `state` holds what was assumed. The fit is of the steel's response at its pose.
Explanation Explain(const Config& config, const Received& received, const Predicted& predicted, State& state) noexcept;

// Of the received scan, with nothing assumed.
ScanContext ContextOf(const Config& config, const Received& received, const Predicted& predicted,
                      const RoomState& room) noexcept;

}  // namespace omni::tracker
