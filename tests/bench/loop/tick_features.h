// Side tables of `omni-bench tick`: cost of each feature in the renderer during contact, and far from everything.
#pragma once

#include <vector>

#include "service/haptics/haptics.h"
#include "service/haptics/scene/scene_input.h"
#include "tests/bench/harness/bench.h"

namespace omni::bench {

// A plain body and the renderer's input while a pen touched it.
struct TouchedBody {
  haptics::SceneInput input;  // one object, one material
  std::vector<haptics::Input> touch;
};

// Rows {table, feature, off_us_median, on_us_median, off_us_p99, on_us_p99}, then
// {table, scene, triangles, ns_median, ns_p99} of a tip 50 mm above.
base::Result<BenchRows> TickFeatureRows(const TouchedBody& body, bool quick);

}  // namespace omni::bench
