// A wall rendered through the whole tick on the digital twin: sensors, tracker, contact, coils. Worst of the rigs: rms
// of the coils' force above 30 Hz and of the tip in the last second, greatest force, total energy that the coils
// delivered to the pen.
#pragma once

#include <cstdint>

#include "service/base/result.h"
#include "tests/bench/harness/bench.h"

namespace omni::bench {

base::Result<BenchRows> ClosedLoop(std::uint64_t seed, bool quick);

}  // namespace omni::bench
