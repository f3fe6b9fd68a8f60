// First stage: a scan as the base sent it becomes one that can be evaluated.
#pragma once

#include "service/base/hall_scan.h"
#include "service/tracker/tracker.h"

namespace omni::tracker {

struct Received {
  base::HallScan scan;         // without the sensors' learnt zeros
  CurrentHistory before, now;  // the coils' currents until the scan before, and with this one
  double since_last_s = 0;     // since that scan
  bool frozen = false;         // every sensor repeats itself
};

// False: the scan has the stamp of the one before; only state.room.old_scans has changed.
bool Receive(const Config& config, const base::HallScan& as_read, State& state, Received& received) noexcept;

}  // namespace omni::tracker
