// Last stages: what a scan says of base and room, and the pose, or the last one held.
#pragma once

#include "service/tracker/stages/hypothesis.h"

namespace omni::tracker {

// One scan and how it was explained.
struct Observation {
  const Config& config;
  const Received& received;
  const Predicted& predicted;
  const Explanation& explanation;

  bool good() const noexcept { return explanation.outcome.good; }
  bool warm() const noexcept { return good() && !explanation.outcome.cold; }
};

// Fourth stage: what an explained scan, or one without a pose, says of base and room. False: the pose is explained by a
// room that cannot exist. What was known of room and pose is dropped then.
bool Learn(const Observation& observation, State& state) noexcept;

// Without a pose in this scan, the pen counts as absent.
bool WillBeAbsent(const Config& config, const PoseState& pose) noexcept;

// Fifth stage: filters the fit from its prediction, `filter`, and publishes it in state.pose.published; without a good
// one holds the last pose.
void Publish(const Observation& observation, FilterState& filter, State& state) noexcept;

// The same for a scan with the stamp of the one before.
void PublishRepeated(const Config& config, const base::HallScan& scan, State& state) noexcept;

}  // namespace omni::tracker
