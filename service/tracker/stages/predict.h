// Second stage: what is known of the room and of the pen, at the scan's time.
#pragma once

#include <optional>

#include "service/tracker/kernel/steel.h"
#include "service/tracker/stages/receive.h"

namespace omni::tracker {

struct Predicted {
  explicit Predicted(const FilterState& last) noexcept : filter(last) {}

  FilterState filter;  // of the pen, if it continues; else as it was last
  double dt_s = 0;     // since it was corrected
  bool continues = false;
  bool wide = false;  // all drifting quantities are unknowns of this scan
  AmbientChange mains;
  std::optional<SteelResponse> steel;  // to the pen as expected
};

// pushed: a force has acted on the pen since the previous scan.
Predicted PredictTo(const Config& config, const Received& received, bool pushed, State& state) noexcept;

}  // namespace omni::tracker
