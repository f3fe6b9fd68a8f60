// What an ordinary hand presses in the benchmarks of tracking.
#pragma once

#include "service/base/result.h"
#include "service/haptics/scene.h"

namespace omni::bench {

// A box on the base, which the hand presses as it moves.
base::Result<haptics::Scene> PressedBox();

}  // namespace omni::bench
