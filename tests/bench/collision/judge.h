// Counts what must not happen, no force inside or a force outside, and the angle between the force and the direction to
// the nearest point.
#pragma once

#include "service/haptics/haptics.h"
#include "tests/bench/collision/oracle.h"

namespace omni::collision {

inline constexpr double kMissedDepth_m = 50e-6;   // deeper than this and no force: missed
inline constexpr double kFalseHeight_m = 100e-6;  // higher than this and a force: false

struct Verdict {
  std::uint64_t ticks = 0, inside = 0, outside = 0, missed = 0, wrong = 0;
  double deepest_m = 0;
  std::vector<double> direction_deg;  // at kMissedDepth_m and deeper
  std::uint64_t checked = 0;          // ticks in which the oracle was compared with sums over all triangles ...
  std::uint64_t oracle_wrong = 0;     // ... and where it differed
};

// Walks the path through haptics::Step (Enter first). Every `check_every`-th tick the oracle itself is checked.
void JudgePath(const Body& body, const Oracle& oracle, const haptics::Scene& scene, const std::vector<Vec3>& path,
               std::size_t check_every, Verdict& verdict);

}  // namespace omni::collision
