// Fourth stage: what an explained scan, or one without a pose, says of base and room.
#pragma once

#include "service/tracker/stages/explain.h"

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

// False: the pose is explained by a room that cannot exist. What was known of room and pose is dropped then.
bool Learn(const Observation& observation, State& state) noexcept;

}  // namespace omni::tracker
