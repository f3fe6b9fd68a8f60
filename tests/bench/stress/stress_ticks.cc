#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/stress/stress.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/rig/scan_faults.h"
#include "tests/support/rig/trace.h"

namespace omni::bench {
namespace {

constexpr double kTickTrace_s = 20;
constexpr int kEpisodeTicksMax = 200;
constexpr int kPauseTicksMax = 300;
constexpr int kGraceTicks = 20;         // a removed pen may be published for so long
constexpr double kLimitSlack_A = 1e-9;  // rounding

bool AllFinite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}
bool AllFinite(const base::Vec3& v) { return AllFinite({v.x, v.y, v.z}); }

bool IsFinite(const loop::TickOutput& out) {
  const base::ToolState& tool = out.tool;
  const base::Quat& q = out.orientation_base_tool;
  const auto& I = out.currents.current_A;
  return AllFinite(tool.position_base_m) && AllFinite(tool.axis_base) && AllFinite(tool.velocity_base_m_s) &&
         AllFinite(tool.angular_velocity_base_rad_s) && AllFinite(tool.device_point_base_m) &&
         AllFinite(tool.device_point_velocity_base_m_s) && AllFinite(out.haptics.force_base_N) &&
         AllFinite(out.wrench.force_N) && AllFinite(out.wrench.torque_Nm) && AllFinite(out.wrench.point_base_m) &&
         AllFinite({tool.gap_m, tool.chi2, q.w, q.x, q.y, q.z, I[0], I[1], I[2], out.gate}) &&
         std::all_of(tool.covariance.begin(), tool.covariance.end(), [](double c) { return std::isfinite(c); });
}

struct Tally {
  std::uint64_t ticks = 0, not_finite = 0, over_limit = 0, allocations = 0, tracking = 0, wrong = 0, silent = 0;
  std::uint64_t over_2mm = 0, over_2mm_silent = 0;  // of a pen that is there
  double current_max_A = 0;
  int recovery_ticks_max = 0;  // after an episode, until a right pose is published

  void Add(const Tally& other) {
    ticks += other.ticks, not_finite += other.not_finite, over_limit += other.over_limit;
    allocations += other.allocations, tracking += other.tracking, wrong += other.wrong, silent += other.silent;
    over_2mm += other.over_2mm, over_2mm_silent += other.over_2mm_silent;
    current_max_A = std::max(current_max_A, other.current_max_A);
    recovery_ticks_max = std::max(recovery_ticks_max, other.recovery_ticks_max);
  }
};

// The state of the run: the active fault, its duration, and since when the tracker has been wrong.
class StressRun {
 public:
  StressRun(const loop::TickConfig& config, const haptics::Scene& scene, sim::Rig& rig, std::uint64_t seed)
      : config_(config),
        scene_(scene),
        rig_(rig),
        random_(seed),
        context_{random_, {}, {}, {}, 0, sim::NoiseOf_T(sim::NoiseMode::kLowPower)[0]},
        tallies_(sim::ScanFaults().size()) {
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      sim::CoilArray unit{};
      unit[k] = 1;
      coil_map_[k] = rig_.Readings(nullptr, unit);
    }
    loop::EnterScene(scene_, 1, *state_);
  }

  void Tick(const sim::TraceRow& row, std::int64_t t_offset_ns, std::uint64_t sequence_offset) {
    base::HallScan scan = row.scan;
    scan.t_ns += t_offset_ns;
    scan.sequence += sequence_offset;
    MoveEpisode(scan);
    if (fault_ == 0) context_.held = scan;
    PlaceNoPen(scan);
    sim::ScanFaults()[fault_].apply(context_, scan);
    const loop::Commands commands = DrawCommands(scan);
    const loop::AllocProbe probe;
    loop::Tick(config_, scan, commands, scene_, *state_, *output_, feeds_);
    const std::uint64_t allocations = probe.count();
    if (output_->wants_scene) loop::EnterScene(scene_, commands.scene_generation, *state_);
    Count(row, allocations);
  }

  const std::vector<Tally>& tallies() const { return tallies_; }

 private:
  void MoveEpisode(const base::HallScan& scan) {
    if (--left_ > 0) return;
    if (fault_ != 0) {
      after_ = fault_;
      recovery_ticks_ = 0;
      fault_ = 0;
      left_ = 1 + static_cast<int>(random_.Uniform(0, kPauseTicksMax));
      return;
    }
    fault_ = 1 + random_.Bits() % (sim::ScanFaults().size() - 1);
    left_ = 1 + static_cast<int>(random_.Uniform(0, kEpisodeTicksMax));
    episode_ticks_ = 0;
    // One sensor as often as many.
    context_.sensors = 1U << (random_.Bits() % base::kSensorCount);
    if (random_.Bits() & 1U) context_.sensors |= static_cast<std::uint32_t>(random_.Bits()) & 0xffU;
    context_.held = scan;
    const sim::MagnetPose other =
        rig_.DrawPose({.radius_min_m = 0.06, .radius_max_m = 0.25, .tilt_max_rad = 3.14}, random_);
    if (sim::ScanFaults()[fault_].name == kTwoMagnets) context_.other_magnet = rig_.Readings(&other, {});
  }

  void PlaceNoPen(const base::HallScan& scan) {
    for (std::size_t i = 0; i < context_.no_pen.size(); ++i) {
      base::Vec3& field = context_.no_pen[i] = {};
      for (std::size_t k = 0; k < base::kCoilCount; ++k) {
        const base::Vec3& per_A = coil_map_[k][i];
        const double current_A = scan.coil_current_A[k];
        field = {field.x + current_A * per_A.x, field.y + current_A * per_A.y, field.z + current_A * per_A.z};
      }
    }
  }

  // Mostly what the daemon would send; now and then numbers that no client should send.
  loop::Commands DrawCommands(const base::HallScan& scan) {
    loop::Commands commands{.t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
    const std::uint64_t draw = random_.Bits() % 64;
    feeds_.owner_silence_ns = draw == 0 ? std::numeric_limits<std::int64_t>::max() : 0;
    if (draw == 1) commands.force_scale = std::nan("");
    if (draw == 2) commands.t_ns = 0;
    if (draw == 3) commands.scene_generation = 2 + random_.Bits() % 3;
    if (draw < 16) {
      commands.haptic = {.id = random_.Bits() % 4,
                         .active = true,
                         .duration_s = draw == 4 ? std::nan("") : 0.05,
                         .amplitude = draw == 5   ? 1e300
                                      : draw == 6 ? std::nan("")
                                                  : 1.0,
                         .frequency_Hz = draw == 7 ? std::nan("") : 100};
    }
    return commands;
  }

  void Count(const sim::TraceRow& row, std::uint64_t allocations) {
    Tally& tally = tallies_[fault_];
    ++tally.ticks;
    ++episode_ticks_;
    tally.allocations += allocations;
    tally.not_finite += IsFinite(*output_) ? 0 : 1;
    double current_A = 0;
    for (const double I : output_->currents.current_A) current_A = std::max(current_A, std::abs(I));
    tally.current_max_A = std::max(tally.current_max_A, current_A);
    tally.over_limit += current_A <= config_.actuation.current_max_A + kLimitSlack_A ? 0 : 1;  // counts NaN as well
    const bool tracking = output_->tool.status == base::TrackingStatus::kTracking;
    tally.tracking += tracking ? 1 : 0;
    const bool right = tracking && !ErrorOf(row.pose, output_->tool.position_base_m, output_->tool.axis_base).failed();
    const bool wrong = tracking && (sim::ScanFaults()[fault_].pen_is_there ? !right : episode_ticks_ > kGraceTicks);
    tally.wrong += wrong ? 1 : 0;
    tally.silent += wrong && output_->tool.limits == 0 ? 1 : 0;
    if (tracking && sim::ScanFaults()[fault_].pen_is_there) CountLarge(row, tally);
    if (fault_ != 0 || after_ == 0) return;
    ++recovery_ticks_;
    if (!right) return;
    tallies_[after_].recovery_ticks_max = std::max(tallies_[after_].recovery_ticks_max, recovery_ticks_);
    after_ = 0;
  }

  void CountLarge(const sim::TraceRow& row, Tally& tally) const {
    const PoseError error = ErrorOf(row.pose, output_->tool.position_base_m, output_->tool.axis_base);
    if (error.position_m <= kLarge_m) return;
    ++tally.over_2mm;
    tally.over_2mm_silent += IsSilent(error, output_->tool) ? 1 : 0;
  }

  static constexpr std::string_view kTwoMagnets = "two magnets";

  const loop::TickConfig& config_;
  const haptics::Scene& scene_;
  sim::Rig& rig_;
  sim::Random random_;
  sim::FaultContext context_;
  std::array<std::array<base::Vec3, base::kSensorCount>, base::kCoilCount> coil_map_;
  loop::TickFeeds feeds_;
  std::vector<Tally> tallies_;
  std::unique_ptr<loop::LoopState> state_ = std::make_unique<loop::LoopState>();
  std::unique_ptr<loop::TickOutput> output_ = std::make_unique<loop::TickOutput>();
  std::size_t fault_ = 0;
  std::size_t after_ = 0;
  int left_ = kPauseTicksMax;
  int episode_ticks_ = 0;
  int recovery_ticks_ = 0;
};

nlohmann::ordered_json Row(const char* key, const std::string& name, const Tally& tally, std::uint64_t seed) {
  return {{key, name},
          {"ticks", tally.ticks},
          {"not_finite", tally.not_finite},
          {"over_limit", tally.over_limit},
          {"allocations", tally.allocations},
          {"tracking", tally.tracking},
          {"wrong", tally.wrong},
          {"silent", tally.silent},
          {"over_2mm", tally.over_2mm},
          {"over_2mm_silent", tally.over_2mm_silent},
          {"current_max_A", tally.current_max_A},
          {"recovery_ms", tally.recovery_ticks_max},
          {"seed", seed}};
}

// By fault.
using Tallies = std::vector<Tally>;

Tally SumOf(const Tallies& tallies) {
  Tally sum;
  for (const Tally& tally : tallies) sum.Add(tally);
  return sum;
}

Tallies StressIn(const RoomCondition& condition, const loop::TickConfig& config, const haptics::Scene& scene,
                 const base::DeviceGeometry& device, std::uint64_t ticks, std::uint64_t seed) {
  loop::FlushDenormals();
  base::TruthParameters truth = RoomOf(condition);
  sim::Random draw(seed);
  if (condition.later) condition.later(truth, draw);
  sim::Rig rig(device, sim::OptionsOf(seed, sim::NoiseMode::kLowPower, truth));
  sim::TraceOptions trace_options{.duration_s = kTickTrace_s, .seed = seed};
  trace_options.motion.seed = seed;
  trace_options.currents = sim::StaggeredSawtooth(4, 0.5);
  const std::vector<sim::TraceRow> trace = sim::RecordTrace(rig, trace_options);
  StressRun run(config, scene, rig, seed);
  // The trace repeats; at its restart the pen jumps, which a tracker must survive as well.
  const std::int64_t period_ns = static_cast<std::int64_t>(trace.size()) * base::kTickPeriod_ns;
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const std::uint64_t pass = tick / trace.size();
    run.Tick(trace[tick % trace.size()], static_cast<std::int64_t>(pass) * period_ns, pass * trace.size());
  }
  return run.tallies();
}

// One base, calibrated once in each room that is needed.
using Configs = std::map<std::string, std::optional<base::Result<loop::TickConfig>>>;

Configs CalibratedIn(const std::vector<RoomCondition>& conditions, const base::DeviceGeometry& device,
                     std::uint64_t seed) {
  Configs configs;
  std::vector<const RoomCondition*> first;  // of each room
  for (const RoomCondition& condition : conditions) {
    if (configs.try_emplace(SurroundingsOf(condition)).second) first.push_back(&condition);
  }
  base::InParallel(first.size(),
                   [&](std::size_t r) { configs.at(SurroundingsOf(*first[r])) = ConfigIn(*first[r], device, seed); });
  return configs;
}

}  // namespace

base::Result<BenchRows> StressTicks(std::uint64_t ticks, std::uint64_t seed,
                                    const std::vector<RoomCondition>& conditions) {
  auto loaded = tools::LoadLiveScene(tools::ShippedScene("extrusion"), {});
  if (!loaded.ok()) return base::Error{loaded.error()};
  const base::DeviceGeometry device = FastDevice();
  const Configs configs = CalibratedIn(conditions, device, seed);
  for (const auto& [room, config] : configs) {
    if (!config->ok()) return base::Error{room + ": " + config->error() + "; try another --seed"};
  }
  std::vector<Tallies> done(conditions.size());
  base::InParallel(conditions.size(), [&](std::size_t c) {
    const std::uint64_t share = ticks / conditions.size() + (c < ticks % conditions.size() ? 1 : 0);
    done[c] = StressIn(conditions[c], **configs.at(SurroundingsOf(conditions[c])), loaded->scene, device, share, seed);
  });

  Tallies by_fault(sim::ScanFaults().size());
  BenchRows rows, by_condition;
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    for (std::size_t f = 0; f < by_fault.size(); ++f) by_fault[f].Add(done[c][f]);
    nlohmann::ordered_json row = Row("condition", conditions[c].name, SumOf(done[c]), seed);
    row["table"] = "conditions";
    by_condition.push_back(std::move(row));
  }
  for (std::size_t f = 0; f < by_fault.size(); ++f) {
    rows.push_back(Row("fault", sim::ScanFaults()[f].name, by_fault[f], seed));
  }
  rows.push_back(Row("fault", "all", SumOf(by_fault), seed));
  Append(by_condition, rows);
  return rows;
}

}  // namespace omni::bench
