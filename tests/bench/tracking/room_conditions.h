// What happens to bases in `omni-bench room`: a table of conditions.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "service/base/truth_parameters.h"
#include "service/sim/random.h"

namespace omni::bench {

constexpr double kRoomRun_s = 60;

// What happens to a base after its calibration; `draw` is of the rig.
using Happening = std::function<void(base::TruthParameters&, sim::Random& draw)>;

struct RoomCondition {
  std::string name;
  bool ideal = false;                                 // no room
  std::function<void(base::TruthParameters&)> known;  // in the room already while the base is calibrated
  Happening later;
  std::vector<double> events_s = {};  // from which it has to recover
  bool as_drawn = false;              // never calibrated
};

std::vector<RoomCondition> RoomConditions();

}  // namespace omni::bench
