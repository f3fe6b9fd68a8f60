// omni-bench numbers: every number of the tracker's options on trial. Scans of several bases in several rooms, waved
// and pressed with the numbers as they are, are tracked again with each number scaled by .7 and by 1.4: all runs have
// the same scans. A simulation: the twin makes the scans and is the reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/sim/hand/ordinary_hand.h"
#include "service/sim/twin/loopback.h"
#include "service/tools/common/statistics.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/harness/room_conditions.h"
#include "tests/bench/harness/tracker_numbers.h"
#include "tests/bench/tracking/pressed_box.h"
#include "tests/support/rig/magnet_of_scan.h"
#include "tests/support/rig/trace.h"

namespace omni::bench {
namespace {

constexpr double kRun_s = 10;
constexpr std::size_t kBases = 2;
constexpr std::array<double, 2> kFactors{0.7, 1.4};
// A change that is no effect: of mean error and of the median of published sigmas, relative; of the shares of ticks
// with a pose, with an error beyond five sigma, and with another report.
constexpr double kSameError = 0.005, kSameSigma = 0.005, kSameShare = 5e-4;
constexpr const char* kConditions[] = {"room",      "as-drawn",       "ambient-20uT", "turning-90",
                                       "steel-150", "second-pen-200", "gain-3",       "stuck",
                                       "mains-5uT", "pen-0.90",       "offsets-50mG"};
constexpr const char* kComesAndGoes = "comes-and-goes";
constexpr double kStay_s = 1.5, kGone_s = 1;

struct RecordedScan {
  base::HallScan scan;
  bool pushed = false, present = true;
  base::Vec3 centre_base_m;
};

struct Recording {
  std::string name;
  tracker::Config config;
  std::vector<RecordedScan> scans;
};

// What a run came to.
struct Result {
  double mean_mm = 0, sigma_mm = 0;
  double posed = 0, silent = 0;        // shares of ticks
  std::vector<std::uint32_t> reports;  // by tick: all that is said beside the pose
};

std::uint32_t ReportOf(const base::ToolState& tool) {
  return tool.limits | tool.sensors_left_out << 8 | static_cast<std::uint32_t>(tool.magnet) << 16 |
         (tool.stray_rms_T > 0 ? 1U << 20 : 0) | static_cast<std::uint32_t>(tool.status) << 24;
}

Result Track(const Recording& recording, const tracker::Config& config) {
  Result result;
  auto state = std::make_unique<tracker::State>();
  base::ToolState tool;
  std::vector<double> error_mm, sigma_mm;
  double silent = 0;
  for (const RecordedScan& row : recording.scans) {
    tracker::Update(config, row.scan, *state, tool, row.pushed);
    result.reports.push_back(ReportOf(tool));
    if (tool.status != base::TrackingStatus::kTracking) continue;
    if (!row.present) {  // a pose of nothing
      ++silent;
      continue;
    }
    error_mm.push_back(1e3 * base::Norm(tool.position_base_m - row.centre_base_m));
    sigma_mm.push_back(1e3 * std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]));
    silent += error_mm.back() > kSilentSigmas * sigma_mm.back() ? 1 : 0;
  }
  const auto ticks = static_cast<double>(recording.scans.size());
  result.mean_mm = tools::Mean(error_mm);
  result.sigma_mm = tools::Quantile(sigma_mm, 0.5);
  result.posed = static_cast<double>(error_mm.size()) / ticks;
  result.silent = silent / ticks;
  return result;
}

sim::MotionOptions Waving(std::uint64_t seed) {
  return {.seed = seed, .radius_max_m = 0.09, .tilt_max_rad = std::numbers::pi / 4};
}

void AddWave(const base::DeviceGeometry& device, const base::TruthParameters& truth, std::uint64_t seed,
             const sim::TraceOptions& options, std::vector<RecordedScan>& scans) {
  sim::Rig rig(device, sim::OptionsOf(seed, sim::NoiseMode::kLowPower, truth));
  const std::int64_t after_ns = scans.empty() ? 0 : scans.back().scan.t_ns + base::kTickPeriod_ns;
  const std::vector<sim::TraceRow> rows = sim::RecordTrace(rig, options);
  for (const sim::TraceRow& row : rows) {
    RecordedScan scan{.scan = row.scan, .present = options.present, .centre_base_m = row.pose.centre_base_m};
    if (after_ns > 0) scan.scan.t_ns += after_ns - rows.front().scan.t_ns;
    scans.push_back(scan);
  }
}

std::vector<RecordedScan> Press(const base::DeviceGeometry& device, const loop::TickConfig& config,
                                const base::TruthParameters& truth, std::uint64_t seed, const haptics::Scene& scene) {
  sim::PlantOptions plant{.seed = seed,
                          .script = sim::MakeOrdinaryHand(device, {.seed = seed + 2, .duration_s = kRun_s})};
  plant.truth = truth;
  sim::Loopback base(device, plant);
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  loop::EnterScene(scene, 1, *state);
  support::MagnetOfScan magnet(base.core().Truth());
  std::vector<RecordedScan> scans(static_cast<std::size_t>(kRun_s / base::kTickPeriod_s));
  for (RecordedScan& row : scans) {
    base.Tick(row.scan);
    row.centre_base_m = magnet.At(row.scan.t_ns, base.core().Truth());
    row.pushed = state->limiter.last_N != base::Vec3{};
    const loop::Commands commands{
        .t_ns = row.scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
    loop::Tick(config, row.scan, commands, scene, *state, *output);
    base.Write(output->currents);
  }
  return scans;
}

// Of one base, in all rooms. Error: a calibration was refused.
base::Result<std::vector<Recording>> Record(std::uint64_t seed, const haptics::Scene& scene) {
  const base::DeviceGeometry device = FastDevice();
  std::vector<Recording> recordings;
  std::map<std::string, loop::TickConfig> configs;
  for (const RoomCondition& condition : RoomConditions()) {
    if (std::find(std::begin(kConditions), std::end(kConditions), condition.name) == std::end(kConditions)) continue;
    const std::string surroundings = SurroundingsOf(condition);
    if (configs.count(surroundings) == 0) {
      auto config = ConfigIn(condition, device, seed);
      if (!config.ok()) return base::Error{condition.name + ": " + config.error()};
      configs.emplace(surroundings, *std::move(config));
    }
    const loop::TickConfig& config = configs.at(surroundings);
    base::TruthParameters truth = RoomOf(condition);
    sim::Random draw(seed ^ 0xA11);
    if (condition.later) condition.later(truth, draw);
    Recording waved{.name = condition.name, .config = config.tracker};
    AddWave(device, truth, seed, {.duration_s = kRun_s, .seed = seed + 1, .motion = Waving(seed + 2)}, waved.scans);
    recordings.push_back(std::move(waved));
    recordings.push_back({condition.name + ", pressed", config.tracker, Press(device, config, truth, seed, scene)});
    if (condition.name != "room") continue;
    Recording comes{.name = kComesAndGoes, .config = config.tracker};
    for (std::uint64_t k = 0; k < 4; ++k) {
      AddWave(device, truth, seed, {.duration_s = kGone_s, .seed = seed + 10 + k, .present = false}, comes.scans);
      AddWave(device, truth, seed, {.duration_s = kStay_s, .seed = seed + 20 + k, .motion = Waving(seed + 30 + k)},
              comes.scans);
    }
    recordings.push_back(std::move(comes));
  }
  return recordings;
}

// The greatest change over all recordings.
struct Effect {
  double error = 0, sigma = 0, posed = 0, silent = 0, reports = 0;
  std::string of_error;  // the recording

  void Add(const std::string& name, const Result& before, const Result& now) {
    const auto keep = [](double change, double& most) {
      const bool more = std::abs(change) > std::abs(most);
      if (more) most = change;
      return more;
    };
    if (keep(now.mean_mm / before.mean_mm - 1, error)) of_error = name;
    keep(now.sigma_mm / before.sigma_mm - 1, sigma);
    keep(now.posed - before.posed, posed);
    keep(now.silent - before.silent, silent);
    double other = 0;
    for (std::size_t i = 0; i < before.reports.size(); ++i) other += before.reports[i] != now.reports[i] ? 1 : 0;
    keep(other / static_cast<double>(before.reports.size()), reports);
  }
  bool none() const {
    return std::abs(error) < kSameError && std::abs(sigma) < kSameSigma && std::abs(posed) < kSameShare &&
           std::abs(silent) < kSameShare && reports < kSameShare;
  }
};

}  // namespace

base::Result<BenchRows> BenchNumbers(const BenchOptions& options) {
  const auto box = PressedBox();
  if (!box.ok()) return base::Error{box.error()};
  tracker::Config plain;
  const std::vector<TrackerNumber> listed = TrackerNumbers(plain);
  std::vector<std::array<Effect, kFactors.size()>> effects(listed.size());
  const std::size_t bases = options.quick ? 1 : kBases;
  for (std::size_t b = 0; b < bases; ++b) {
    const auto recordings = Record(1000 * options.seed + 10 * b, *box);
    if (!recordings.ok()) return base::Error{recordings.error()};
    std::vector<Result> before(recordings->size());
    base::InParallel(before.size(),
                     [&](std::size_t r) { before[r] = Track((*recordings)[r], (*recordings)[r].config); });
    base::InParallel(listed.size(), [&](std::size_t n) {
      if (options.quick && n % 16 != 0) return;
      for (std::size_t r = 0; r < recordings->size(); ++r) {
        for (std::size_t f = 0; f < kFactors.size(); ++f) {
          tracker::Config config = (*recordings)[r].config;
          Scale(kFactors[f], TrackerNumbers(config)[n]);
          effects[n][f].Add((*recordings)[r].name, before[r], Track((*recordings)[r], config));
        }
      }
    });
  }
  BenchRows rows;
  for (std::size_t n = 0; n < listed.size(); ++n) {
    if (options.quick && n % 16 != 0) continue;
    for (std::size_t f = 0; f < kFactors.size(); ++f) {
      const Effect& effect = effects[n][f];
      rows.push_back({{"number", listed[n].name},
                      {"factor", kFactors[f]},
                      {"bases", bases},
                      {"seed", options.seed},
                      {"error_change_pct", 100 * effect.error},
                      {"most_in", effect.of_error},
                      {"sigma_change_pct", 100 * effect.sigma},
                      {"posed_change", effect.posed},
                      {"silent_change", effect.silent},
                      {"reports_changed", effect.reports},
                      {"no_effect", effect.none()}});
    }
  }
  return rows;
}

}  // namespace omni::bench
