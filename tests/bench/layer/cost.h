// Cost of calls: time, calls of the runtime below, system calls, memory. Results go to stdout as JSON.
#pragma once

#include <string>

#include "tests/bench/layer/app.h"

namespace omni::bench {

// [{"call", "ns_median", "ns_p99", "below"}]: below is the number of calls of the runtime's function per call; -1 if
// `runtime` (its library, if it has omni_test_call_count) does not count them.
void TimeCalls(const App& app, const std::string& runtime);

// For a tracer: `times` calls of each counted kind between markers (getppid).
void CountBetweenMarkers(const App& app, int times);

// {"instance_bytes", "session_bytes", "mapped_bytes"}: of the heap (mallinfo2) that an instance takes, a session with
// its actions and spaces in use, and of shared memory. The second instance is counted.
void PrintMemory(bool pen);

}  // namespace omni::bench
