// Parts of omni-bench race.
#pragma once

#include <cstdint>

#include "tests/bench/harness/bench.h"

namespace omni::bench {

// Side table "walls": cars moving in closed chambers with corners of every angle, and how many got out. `throws` is
// their total number.
void BenchRaceWalls(std::uint64_t seed, std::uint64_t throws, BenchRows& rows);

// Side table "cost": cost of a tick of the race, by situation.
base::Status BenchRaceCost(BenchRows& rows);

}  // namespace omni::bench
