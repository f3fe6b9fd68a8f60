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

// Faults in episodes upon a moving pen, fed to Tick: rows fault, ticks, not_finite, over_limit, allocations, tracking,
// wrong (by kFailure_m), silent (wrong and no ToolState::limits bit says so), over_2mm, over_2mm_silent (of more than
// kSilentSigmas published standard deviations), current_max_A, recovery_ms, seed; the last row sums up.
// Side table "conditions": the same by what happens to the room. The ticks are shared out between the conditions, in
// each of which a base is calibrated that is drawn by the seed. Error: it could not be.
base::Result<BenchRows> StressTicks(std::uint64_t ticks, std::uint64_t seed,
                                    const std::vector<RoomCondition>& conditions);

// Side table "basin": starts off by so much, shares of solves that arrive.
base::Result<BenchRows> StressBasins(std::uint64_t solves, std::uint64_t seed);

// Side table "singular poses": where a model, a tangent basis or a force map could divide by zero.
BenchRows StressSingularPoses(std::uint64_t seed);

// A room over time, a moment every kCourseStep_s; the first is that of the calibration.
inline constexpr double kCourseStep_s = 60;
struct RoomMoment {
  base::Vec3 ambient_base_T;  // by which the field has changed
  double magnet_K = 0, sensor_K = 0;
};
using RoomCourse = std::vector<RoomMoment>;
// The field wanders at random, magnet and sensors warm up and cool down in turns. `steps` + 1 moments.
RoomCourse MakeRoomCourse(std::size_t steps, std::uint64_t seed);

// Side table "drift": that room for `hours` of virtual time, the pen waved for some seconds of each minute. Error: the
// base could not be calibrated.
base::Result<BenchRows> StressDrift(double hours, std::uint64_t seed);

}  // namespace omni::bench
