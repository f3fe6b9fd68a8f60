// Cost of unknown currents: time of the tracker's part of a tick, and error. Batches take turns.
#include <vector>

#include "service/config/files/device_file.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/timing.h"
#include "tests/bench/tracking/tracking.h"
#include "tests/support/rig/trace.h"

namespace omni::bench {
namespace {

constexpr double kLevelTrace_s = 20;
constexpr std::size_t kSettleTicks = 200;
constexpr std::size_t kRounds = 200;
constexpr std::size_t kTries = 3;  // per round, when the machine takes the core away

struct LevelRun {
  const char* name;
  bool currents_hidden;
  tracker::Config config;
  tracker::State state;
  base::ToolState tool;
  CallTimer timer;
  ErrorSet errors;
};

ErrorSet ErrorsOf(const tracker::Config& config, const std::vector<sim::TraceRow>& trace) {
  ErrorSet errors;
  tracker::State state;
  base::ToolState tool;
  for (std::size_t i = 0; i < trace.size(); ++i) {
    tracker::Update(config, trace[i].scan, state, tool);
    if (i < kSettleTicks) continue;
    if (tool.status == base::TrackingStatus::kTracking) {
      errors.Add(ErrorOf(trace[i].pose, tool.position_base_m, tool.axis_base));
    } else {
      errors.AddMissing();
    }
  }
  return errors;
}

}  // namespace

base::Result<BenchRows> Levels(const TrackingPlan& plan) {
  const std::uint64_t seed = plan.seeds.front();
  sim::Rig rig(config::DefaultDevice(),
               {.seed = seed, .sizes = sim::NoImperfections(), .noise = sim::NoiseMode::kLowPower});
  sim::TraceOptions options{.duration_s = plan.share > 1 ? 2.0 : kLevelTrace_s, .seed = seed};
  options.motion.seed = seed;
  options.currents = sim::StaggeredSawtooth(4, 0.5);
  const std::vector<sim::TraceRow> trace = sim::RecordTrace(rig, options);

  std::vector<LevelRun> runs{{"position and axis", false, {}, {}, {}, {}, {}},
                             {"position and axis, currents hidden", true, {}, {}, {}, {}, {}}};
  for (LevelRun& run : runs) {
    run.config = tracker::MakeConfig(rig.ExactCalibration());
    run.config.trust.currents_hidden = run.currents_hidden;
    run.errors = ErrorsOf(run.config, trace);
  }
  const std::size_t rounds = std::max<std::size_t>(4, kRounds / plan.share);
  for (std::size_t round = 0; round < rounds; ++round) {
    for (LevelRun& run : runs) {
      const auto call = [&](std::size_t i) {
        const std::size_t at = i % trace.size();
        if (at == 0) run.state = {};
        tracker::Update(run.config, trace[at].scan, run.state, run.tool);
      };
      for (std::size_t attempt = 0; attempt < kTries && run.timer.batches() <= round; ++attempt) run.timer.Batch(call);
    }
  }
  BenchRows rows;
  for (const LevelRun& run : runs) {
    rows.push_back({{"table", "levels"},
                    {"level", run.name},
                    {"us_median", run.timer.us_median()},
                    {"us_p99", run.timer.us_p99()},
                    {"mean_mm", tools::Mean(run.errors.position_mm)},
                    {"p95_mm", tools::Quantile(run.errors.position_mm, 0.95)},
                    {"orientation_mean_deg", tools::Mean(run.errors.axis_deg)},
                    {"failures", run.errors.failures},
                    {"n", trace.size() - kSettleTicks},
                    {"batches", run.timer.batches()},
                    {"seed", seed}});
  }
  return rows;
}

}  // namespace omni::bench
