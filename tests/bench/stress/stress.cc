// omni-bench stress: counts events that must never happen.
#include "tests/bench/stress/stress.h"

#include <algorithm>
#include <iostream>

#include "tests/bench/harness/errors.h"

namespace omni::bench {
namespace {

constexpr std::uint64_t kTicks = 10'000'000;
constexpr std::uint64_t kBasinSolves = 20'000;  // per row
constexpr std::uint64_t kQuick = 100;           // --quick divides by this

}  // namespace

base::Result<BenchRows> BenchStress(const BenchOptions& options) {
  const std::uint64_t share = options.quick ? kQuick : 1;
  const std::uint64_t seed = ThreeSeeds(options.seed).front();
  std::cerr << "faults during motion of the pen, in every condition of a room ...\n";
  std::vector<RoomCondition> conditions = RoomConditions();
  if (options.quick) conditions.resize(1);
  auto rows = StressTicks(options.ticks > 0 ? options.ticks : kTicks / share, seed, conditions);
  if (!rows.ok()) return rows;
  std::cerr << "basins of attraction ...\n";
  auto basins = StressBasins(kBasinSolves / share, seed);
  if (!basins.ok()) return basins;
  Append(*basins, *rows);
  std::cerr << "singular poses ...\n";
  Append(StressSingularPoses(seed), *rows);
  std::cerr << "hours of virtual time ...\n";
  auto drift = StressDrift(options.hours / static_cast<double>(share), seed);
  if (!drift.ok()) return drift;
  Append(*drift, *rows);
  return rows;
}

}  // namespace omni::bench
