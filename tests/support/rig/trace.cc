#include "tests/support/rig/trace.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "service/sim/twin/loopback.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kLead_ns = 100'000'000;  // before the first row: the base is armed, its currents have settled

double SetPoint_A(const Sawtooth& tooth, double t_s) noexcept {
  const double x = t_s / tooth.period_s + tooth.phase;
  return tooth.offset_A + tooth.amplitude_A * (2 * (x - std::floor(x)) - 1);
}

PlantOptions PlantOf(const Rig& rig, const TraceOptions& options) {
  PlantOptions plant;
  plant.seed = options.seed;
  plant.truth.effects = rig.options().effects;
  plant.truth.sensor = rig.options().sensor;
  plant.imperfections = rig.imperfections();
  plant.environment_seed = ~rig.options().seed;
  plant.run_s = options.start_s;
  plant.start_ns = -kLead_ns;
  if (options.present) {
    plant.motion = std::make_shared<FreeMotion>(rig.device(), options.motion, options.duration_s + base::kTickPeriod_s);
  }
  return plant;
}

// Device time 0 is the first row's tick; the lead-in has negative times, with pen and set-points as at 0.
class Run {
 public:
  Run(const Rig& rig, const TraceOptions& options)
      : options_(options), plant_(PlantOf(rig, options)), base_(rig.device(), plant_) {
    while (base_.core().now_ns() < 0) Tick();
  }

  TraceRow Tick() noexcept {
    TraceRow row;
    const double t_s = Seconds(base_.core().now_ns());
    base::CoilCurrents wanted;
    for (std::size_t k = 0; k < wanted.current_A.size(); ++k) {
      wanted.current_A[k] = SetPoint_A(options_.currents[k], t_s);
    }
    base_.Write(wanted);
    base_.Tick(row.scan);
    const std::int64_t at_ns = row.scan.t_ns - Loopback::kClockStart_ns;
    if (plant_.motion != nullptr) {
      const PenMotion::State state = plant_.motion->StateAt(Seconds(at_ns));
      row.pose = state.pose;
      row.velocity_base_m_s = state.velocity_base_m_s;
    }
    row.current_A = base_.core().plant().CurrentAt(at_ns);
    row.tick_end_ns = base_.core().now_ns() + Loopback::kClockStart_ns;
    return row;
  }

 private:
  static double Seconds(std::int64_t t_ns) noexcept { return std::max(0.0, static_cast<double>(t_ns) * 1e-9); }

  TraceOptions options_;
  PlantOptions plant_;
  Loopback base_;
};

}  // namespace

CurrentScript StaggeredSawtooth(double amplitude_A, double period_s) noexcept {
  CurrentScript script;
  for (std::size_t k = 0; k < script.size(); ++k) {
    script[k] = {amplitude_A, period_s, static_cast<double>(k) / static_cast<double>(script.size()), 0};
  }
  return script;
}

std::vector<TraceRow> RecordTrace(Rig& rig, const TraceOptions& options) {
  Run run(rig, options);
  std::vector<TraceRow> rows;
  const auto count = static_cast<std::size_t>(std::llround(options.duration_s / base::kTickPeriod_s));
  rows.reserve(count);
  for (std::size_t i = 0; i < count; ++i) rows.push_back(run.Tick());
  return rows;
}

}  // namespace omni::sim
