// First stages: a scan that can be evaluated, and what is known of room and pen at its time.
#pragma once

#include <optional>

#include "service/base/hall_scan.h"
#include "service/tracker/kernel/steel.h"
#include "service/tracker/tracker.h"

namespace omni::tracker {

// First stage: a scan as the base sent it becomes one that can be evaluated.
struct Received {
  const base::HallScan& as_read;         // outlives this
  std::optional<base::HallScan> zeroed;  // without the sensors' learnt zeros, if there are some
  double since_last_s = 0;               // since the scan before
  bool frozen = false;                   // every sensor repeats itself

  const base::HallScan& scan() const noexcept { return zeroed ? *zeroed : as_read; }
};

// The scan has the stamp of the one before; only room.old_scans has changed.
bool IsRepeated(const Config& config, const base::HallScan& as_read, RoomState& room) noexcept;

Received Receive(const Config& config, const base::HallScan& as_read, RoomState& room) noexcept;

// Second stage: what is known of the room and of the pen, at the scan's time.
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
