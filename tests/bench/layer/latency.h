// From a sensor's sample to the pose that an application sees.
#pragma once

#include "tests/bench/layer/app.h"

namespace omni::bench {

// {"ms_p50", "ms_p99", "n"}: from the stamp of a Hall sample (CLOCK_MONOTONIC) to the return of the first xrLocateSpace
// whose result it changed, over `samples` samples. Calls without a pause, so that the application adds nothing.
void PrintLatency(const App& app, int samples);

}  // namespace omni::bench
