// One scan and its result, for the room watch: now and then, as often without a client as with one.
#pragma once

#include <cstdint>

#include "service/base/hall_scan.h"
#include "service/base/tool_state.h"

namespace omni::tracker {

inline constexpr double kMagnetNear_T = 1e-4;  // twice the earth's field, and what a pen 10 cm above the hull makes

struct RoomSample {
  static constexpr std::int64_t kEvery_ns = 15'500'000;  // every sixteenth scan, on the base's clock
  base::HallScan scan;
  base::ToolState tool;
  double contact_gain = 1;  // of the weakest contact: below 1, it is softer for now
};

}  // namespace omni::tracker
