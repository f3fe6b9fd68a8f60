// omni bench loop: scans of a virtual-time run of the scene's own hand script are recorded once with the loop closed,
// then replayed through Tick as often as wanted. The loop is deterministic, so a replay does exactly what the run did;
// the twin's time is left out.
#include <chrono>
#include <memory>
#include <vector>

#include "service/config/device_file.h"
#include "service/daemon/virtual_run.h"
#include "service/loop/denormals.h"
#include "service/loop/histogram.h"
#include "service/loop/probe/alloc_probe.h"
#include "service/loop/tick_config.h"
#include "service/sim/twin.h"
#include "service/tools/bench.h"
#include "service/tools/scene_source.h"
#include "service/tools/statistics.h"

namespace omni::tools {
namespace {

constexpr const char* kScenes[] = {"extrusion", "dragon", "racetrack"};
constexpr std::uint64_t kTicks = 1'000'000;  // per scene
constexpr double kLate_us = 1000;            // a tick that alone takes longer than its period

base::Result<std::vector<base::HallScan>> RecordScans(const loop::TickConfig& config, const haptics::Scene& scene,
                                                      const std::string& scene_path, std::uint64_t seed) {
  auto hand = sim::LoadHandScript(FindHandScript(scene_path));
  if (!hand.ok()) return base::Error{hand.error()};
  const auto twin = sim::MakeVirtualTwin(config::DefaultDevice(), {.seed = seed, .script = *hand}, hand->duration_s());
  std::vector<base::HallScan> scans;
  daemon::RunVirtual(config, *twin, scene, {},
                     [&](const base::HallScan& scan, const loop::TickOutput&) { scans.push_back(scan); });
  return scans;
}

loop::Commands OpenGate(const base::HallScan& scan) {
  return {.t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
}

struct Timing {
  std::vector<float> us;
  std::uint64_t allocations = 0;
  std::uint64_t late = 0;
};

Timing ReplayTicks(const loop::TickConfig& config, const haptics::Scene& scene,
                   const std::vector<base::HallScan>& scans, std::uint64_t ticks) {
  using Clock = std::chrono::steady_clock;
  Timing timing;
  timing.us.resize(ticks);
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  for (std::uint64_t i = 0; i < ticks; ++i) {
    const base::HallScan& scan = scans[i % scans.size()];
    if (i % scans.size() == 0) {  // the script starts over
      *state = loop::LoopState{};
      loop::EnterScene(scene, 1, *state);
    }
    const loop::Commands commands = OpenGate(scan);
    const loop::AllocProbe probe;
    const Clock::time_point begin = Clock::now();
    loop::Tick(config, scan, commands, scene, *state, *output);
    const Clock::time_point end = Clock::now();
    timing.allocations += probe.count();
    timing.us[i] = std::chrono::duration<float, std::micro>(end - begin).count();
    timing.late += timing.us[i] > static_cast<float>(kLate_us) ? 1 : 0;
  }
  return timing;
}

}  // namespace

base::Result<BenchRows> BenchLoop(const BenchOptions& options) {
  loop::FlushDenormals();
  const loop::TickConfig config = loop::MakeTickConfig(config::DefaultDevice());
  const std::uint64_t ticks = options.ticks > 0 ? options.ticks : kTicks;
  BenchRows rows;
  for (const char* name : kScenes) {
    const std::string path = FindScene(name);
    auto loaded = LoadScene(path, {});
    if (!loaded.ok()) return base::Error{loaded.error()};
    auto scans = RecordScans(config, loaded->scene, path, options.seed);
    if (!scans.ok()) return base::Error{scans.error()};
    const Timing timing = ReplayTicks(config, loaded->scene, *scans, ticks);
    const std::vector<double> us(timing.us.begin(), timing.us.end());
    rows.push_back({{"scene", name},
                    {"ticks", ticks},
                    {"us_median", Quantile(us, 0.5)},
                    {"us_p99", Quantile(us, 0.99)},
                    {"us_max", Quantile(us, 1.0)},
                    {"allocations", timing.allocations},
                    {"late_ticks", timing.late}});
  }
  return rows;
}

}  // namespace omni::tools
