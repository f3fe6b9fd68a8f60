// The parts of `omni-bench stress`, each giving rows.
#pragma once

#include <cstdint>

#include "service/base/result.h"
#include "tests/bench/harness/bench.h"

namespace omni::bench {

// Faults in episodes upon a moving pen, fed to Tick: rows fault, ticks, not_finite, over_limit, allocations, tracking,
// wrong, silent (wrong and no ToolState::limits bit says so), current_max_A, recovery_ms, seed; the last row sums up.
base::Result<BenchRows> StressTicks(std::uint64_t ticks, std::uint64_t seed);

// Side table "basin": starts off by so much, shares of solves that arrive.
base::Result<BenchRows> StressBasins(std::uint64_t solves, std::uint64_t seed);

// Side table "singular poses": where a model, a tangent basis or a force map could divide by zero.
BenchRows StressSingularPoses(std::uint64_t seed);

// Side table "drift": the same minute of motion over and over for `hours` of virtual time.
BenchRows StressDrift(double hours, std::uint64_t seed);

}  // namespace omni::bench
