// The parts of `omni-bench stress`, each giving rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/room_conditions.h"

namespace omni::bench {

// Faults in episodes during motion of the pen, fed to Tick: rows fault, ticks, not_finite, over_limit, allocations,
// tracking, wrong (by kFailure_m), silent (wrong and no ToolState::limits bit says so), over_2mm, over_2mm_silent (of
// more than kSilentSigmas published standard deviations), current_max_A, recovery_ms, seed; the last row sums up. Side
// table "conditions": the same by condition of the room. The ticks are divided among the conditions; in each a base
// given by the seed is calibrated. Error: calibration failed.
base::Result<BenchRows> StressTicks(std::uint64_t ticks, std::uint64_t seed,
                                    const std::vector<RoomCondition>& conditions);

// Side table "basin": starts with given errors, shares of solves that converge.
base::Result<BenchRows> StressBasins(std::uint64_t solves, std::uint64_t seed);

// Side table "singular poses": where a model, a tangent basis or a force map could divide by zero.
BenchRows StressSingularPoses(std::uint64_t seed);

// A room over time, sampled every kCourseStep_s; the first sample is that of the calibration.
inline constexpr double kCourseStep_s = 60;
struct RoomMoment {
  base::Vec3 ambient_base_T;  // by which the field has changed
  double magnet_K = 0, sensor_K = 0;
};
using RoomCourse = std::vector<RoomMoment>;
// The field wanders at random, magnet and sensors warm up and cool down in turns. `steps` + 1 samples.
RoomCourse MakeRoomCourse(std::size_t steps, std::uint64_t seed);

// Side table "drift": that room for `hours` of virtual time, the pen waved for some seconds of each minute. Error: the
// base could not be calibrated.
base::Result<BenchRows> StressDrift(double hours, std::uint64_t seed);

}  // namespace omni::bench
