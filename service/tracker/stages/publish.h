// Last stage: the pose, or the last one held.
#pragma once

#include "service/tracker/stages/learn.h"

namespace omni::tracker {

// Without a pose in this scan, the pen counts as absent.
bool WillBeAbsent(const Config& config, const PoseState& pose) noexcept;

// Filters the fit from its prediction, `filter`, and publishes it in state.pose.published; without a good one holds the
// last pose.
void Publish(const Observation& observation, FilterState& filter, State& state) noexcept;

// The same for a scan with the stamp of the one before.
void PublishRepeated(const Config& config, const base::HallScan& scan, State& state) noexcept;

}  // namespace omni::tracker
