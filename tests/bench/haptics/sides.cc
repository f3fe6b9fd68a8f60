// omni-bench sides: strokes of a point and of a ball over bodies whose meshes are broken.
#include "tests/bench/harness/bench.h"
#include "tests/support/touch/side_judge.h"

namespace omni::bench {

base::Result<BenchRows> BenchSides(const BenchOptions& options) {
  const int strokes = options.quick ? 10 : 200;
  constexpr double kBall_m = 0.0015;  // the default tip
  BenchRows rows;
  for (const haptics::broken::Broken& broken : haptics::broken::BrokenBodies(options.seed, options.quick)) {
    for (const double radius_m : {0.0, kBall_m}) {
      const haptics::broken::SideCounts counts = haptics::broken::Stroke(broken, radius_m, strokes, options.seed);
      rows.push_back({{"body", broken.body},
                      {"defect", broken.defect},
                      {"strokes", counts.strokes},
                      {"path", radius_m > 0 ? "ball" : "point"},
                      {"ticks", counts.ticks},
                      {"inside", counts.inside},
                      {"missed", counts.missed},
                      {"false_contacts", counts.false_contacts}});
    }
  }
  return rows;
}

}  // namespace omni::bench
