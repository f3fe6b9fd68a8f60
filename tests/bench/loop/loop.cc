// omni-bench loop: the whole tick on the shipped scenes, of a calibrated base in a room.
#include <vector>

#include "service/config/files/twin_file.h"
#include "service/loop/realtime.h"
#include "service/tools/common/row_table.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/harness/bench.h"
#include "tests/support/rig/loop_replay.h"

namespace omni::bench {
namespace {

constexpr const char* kScenes[] = {"extrusion", "dragon", "racetrack"};
constexpr std::uint64_t kTicks = 1'000'000;  // per scene

}  // namespace

base::Result<BenchRows> BenchLoop(const BenchOptions& options) {
  loop::FlushDenormals();
  const auto config = test::CalibratedTick(options.seed);
  if (!config.ok()) return base::Error{config.error()};
  const std::uint64_t ticks = options.ticks > 0 ? options.ticks : kTicks;
  BenchRows rows;
  for (const char* name : kScenes) {
    const std::string path = tools::ShippedScene(name);
    auto loaded = tools::LoadLiveScene(path, {});
    if (!loaded.ok()) return base::Error{loaded.error()};
    auto scans = test::RecordScans(*config, loaded->scene, path, options.seed, config::DefaultTwin());
    if (!scans.ok()) return base::Error{scans.error()};
    const test::ReplayTiming timing = test::ReplayTicks(*config, loaded->scene, *scans, ticks);
    rows.push_back({{"scene", name},
                    {"ticks", ticks},
                    {"us_median", tools::Quantile(timing.us, 0.5)},
                    {"us_p99", tools::Quantile(timing.us, 0.99)},
                    {"us_max", tools::Quantile(timing.us, 1.0)},
                    {"allocations", timing.allocations},
                    {"late_ticks", timing.late}});
  }
  return rows;
}

}  // namespace omni::bench
