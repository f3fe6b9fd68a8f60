// First stage: a scan as the base sent it becomes one that can be evaluated.
#pragma once

#include <optional>

#include "service/base/hall_scan.h"
#include "service/tracker/tracker.h"

namespace omni::tracker {

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

}  // namespace omni::tracker
