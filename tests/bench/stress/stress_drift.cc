// Hours of virtual time: the same motion again and again through Tick. Whatever the loop remembers (filter, moment,
// clock, gate, temperatures) must not wander: every hour has the errors of the first.
#include <cmath>
#include <memory>
#include <vector>

#include "service/config/device_file.h"
#include "service/haptics/scene.h"
#include "service/loop/denormals.h"
#include "service/loop/tick_config.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/stress/stress.h"
#include "tests/support/trace.h"

namespace omni::bench {
namespace {

constexpr double kDriftTrace_s = 60;
constexpr double kHour_s = 3600;
constexpr int kRowsMax = 10;
constexpr int kSettleTicks = 50;  // after the jump from the trace's end to its start

}  // namespace

BenchRows StressDrift(double hours, std::uint64_t seed) {
  loop::FlushDenormals();
  const base::DeviceGeometry& device = config::DefaultDevice();
  sim::Rig rig(device, {.seed = seed, .sizes = sim::NoImperfections(), .noise = sim::NoiseMode::kLowPower});
  loop::TickConfig config = loop::MakeTickConfig(device);
  config.tracker = tracker::MakeConfig(rig.ExactCalibration());
  sim::TraceOptions options{.duration_s = kDriftTrace_s, .seed = seed};
  options.motion.seed = seed;
  options.currents = sim::StaggeredSawtooth(4, 0.5);
  const std::vector<sim::TraceRow> trace = sim::RecordTrace(rig, options);

  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  const haptics::Scene scene;
  loop::EnterScene(scene, 1, *state);
  const auto passes = static_cast<std::uint64_t>(std::ceil(hours * kHour_s / kDriftTrace_s));
  const std::uint64_t passes_per_row = std::max<std::uint64_t>(1, passes / kRowsMax);
  BenchRows rows;
  ErrorSet errors;
  for (std::uint64_t pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 0; i < trace.size(); ++i) {
      base::HallScan scan = trace[i].scan;
      scan.t_ns += static_cast<std::int64_t>(pass * trace.size()) * base::kTickPeriod_ns;
      scan.sequence += pass * trace.size();
      const loop::Commands commands{
          .t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
      loop::Tick(config, scan, commands, scene, *state, *output);
      const base::ToolState& tool = output->tool;
      if (i < kSettleTicks) continue;
      if (tool.status == base::TrackingStatus::kTracking) {
        // One pass per row is enough for its statistics; the others only count failures.
        const PoseError error = ErrorOf(trace[i].pose, tool.position_base_m, tool.axis_base);
        if (pass % passes_per_row == 0) errors.Add(error);
        if (pass % passes_per_row != 0 && error.failed()) ++errors.failures;
      } else {
        errors.AddMissing();
      }
    }
    if ((pass + 1) % passes_per_row != 0) continue;
    rows.push_back({{"table", "drift"},
                    {"hours", static_cast<double>(pass + 1) * kDriftTrace_s / kHour_s},
                    {"mean_mm", tools::Mean(errors.position_mm)},
                    {"p95_mm", tools::Quantile(errors.position_mm, 0.95)},
                    {"max_mm", tools::Quantile(errors.position_mm, 1)},
                    {"orientation_mean_deg", tools::Mean(errors.axis_deg)},
                    {"failures", errors.failures},
                    {"seed", seed}});
    errors = {};
  }
  return rows;
}

}  // namespace omni::bench
