// omni-bench numbers: every number of the tracker's options on trial. Scans of several bases in several rooms, waved
// and pressed with the numbers as they are, are tracked again with each number scaled by .7 and by 1.4: all runs have
// the same scans. A simulation: the twin makes the scans and is the reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/harness/room_conditions.h"
#include "tests/bench/harness/tracker_numbers.h"
#include "tests/bench/tracking/pressed_box.h"
#include "tests/support/hand/ordinary_hand.h"
#include "tests/support/rig/trace.h"

namespace omni::bench {
namespace {

constexpr double kRun_s = 10;
constexpr std::size_t kBases = 2;
using Factors = std::array<double, 2>;
constexpr Factors kFactors{0.7, 1.4};
// A change that is no effect: of mean error and of the median of published sigmas, relative; of the shares of ticks
// with a pose, with an error beyond five sigma, and with another report.
constexpr double kSameError = 0.005, kSameSigma = 0.005, kSameShare = 5e-4;
constexpr const char* kComesAndGoes = "comes-and-goes";        // of the pen, in the room
constexpr const char* kBesideFromStart = "beside-from-start";  // a second pen, before the first scan
constexpr const char* kRests = "rests";
constexpr const char* kInterrupted = "interrupted";
constexpr double kStay_s = 1.5, kGone_s = 2;

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

std::vector<RecordedScan> Pressed(const base::DeviceGeometry& device, const loop::TickConfig& config,
                                  const base::TruthParameters& truth, std::uint64_t seed, const haptics::Scene& scene,
                                  const sim::HandScript& hand) {
  std::vector<RecordedScan> scans;
  Press(device, config, truth, seed, hand, kRun_s, scene, [&](const PressedTick& tick) {
    scans.push_back({.scan = tick.scan, .pushed = tick.pushed, .centre_base_m = tick.magnet_base_m});
  });
  return scans;
}

// Brought, laid down for six seconds, turned and laid down again.
sim::HandScript RestingHand() {
  sim::HandScript hand = sim::MakeOrdinaryHand(FastDevice(), {.seed = 1, .duration_s = kRun_s});
  hand.waypoints.clear();
  const base::Vec3 here{0.01, 0.02, 0.06}, there{-0.02, 0.01, 0.065};
  const base::Vec3 down{0, 0, -1}, tilted{0.3, 0, -0.954};
  for (const auto& [duration_s, tip_m, axis] : {std::tuple{0.5, there, down},
                                                {0.5, here, down},
                                                {5.5, here, down},
                                                {0.5, there, tilted},
                                                {3.0, there, tilted}}) {
    hand.waypoints.push_back({.duration_s = duration_s, .tip_base_m = tip_m, .axis_base = axis});
  }
  return hand;
}

// Now and then one scan is wrong, readings are missing for 30 ms, or the clock stands still.
void Interrupt(std::vector<RecordedScan>& scans) {
  for (std::size_t i = 0; i < scans.size(); ++i) {
    base::HallScan& scan = scans[i].scan;
    const std::size_t phase = i % 900;
    if (phase == 300) scan.field_sensor_T[i / 900 % base::kSensorCount].x += 1e-4;
    if (phase >= 600 && phase < 630) scan.fresh_mask = 0;
    if (phase >= 600 && phase < 630) scan.age_ns.fill(2 * base::kSampleAgeMax_ns);
    if (phase >= 800 && phase < 825) scan.t_ns = scans[i - 1].scan.t_ns;
  }
}

// What is recorded of each base: makes the scans, given the base's configuration in those surroundings.
struct Plan {
  std::string name;
  RoomCondition condition;
  std::function<std::vector<RecordedScan>(const loop::TickConfig&, const base::TruthParameters&, std::uint64_t seed)>
      record;
};

RoomCondition ConditionOf(const std::string& name) {
  for (const RoomCondition& condition : RoomConditions()) {
    if (condition.name == name) return condition;
  }
  return {};
}

std::vector<Plan> Plans(const base::DeviceGeometry& device, const haptics::Scene& scene) {
  std::vector<Plan> plans;
  const auto wave = [&device](const loop::TickConfig&, const base::TruthParameters& truth, std::uint64_t seed) {
    std::vector<RecordedScan> scans;
    AddWave(device, truth, seed, {.duration_s = kRun_s, .seed = seed + 1, .motion = Waving(seed + 2)}, scans);
    return scans;
  };
  for (const RoomCondition& condition : RoomConditions()) {
    plans.push_back({condition.name, condition, wave});
    plans.push_back({condition.name + ", pressed", condition,
                     [&](const loop::TickConfig& config, const base::TruthParameters& truth, std::uint64_t seed) {
                       return Pressed(device, config, truth, seed, scene,
                                      sim::MakeOrdinaryHand(device, {.seed = seed + 2, .duration_s = kRun_s}));
                     }});
  }
  const auto comes_and_goes = [&device](const auto&, const auto& truth, std::uint64_t seed) {
    std::vector<RecordedScan> scans;
    for (std::uint64_t k = 0; k < 4; ++k) {
      AddWave(device, truth, seed, {.duration_s = kGone_s, .seed = seed + 10 + k, .present = false}, scans);
      AddWave(device, truth, seed, {.duration_s = kStay_s, .seed = seed + 20 + k, .motion = Waving(seed + 30 + k)},
              scans);
    }
    return scans;
  };
  plans.push_back({kComesAndGoes, {"room"}, comes_and_goes});
  RoomCondition warmed = ConditionOf("offsets-50mG");
  warmed.later = [warms = warmed.later](base::TruthParameters& truth, sim::Random& draw) {
    warms(truth, draw);
    truth.effects.run_s = 1e-3;  // before the first scan
  };
  plans.push_back({std::string("warmed, ") + kComesAndGoes, warmed, comes_and_goes});
  plans.push_back({kRests, {"room"}, [&device](const auto& config, const auto& truth, std::uint64_t seed) {
                     return Pressed(device, config, truth, seed, {}, RestingHand());
                   }});
  plans.push_back({kInterrupted, {"room"}, [wave](const auto& config, const auto& truth, std::uint64_t seed) {
                     std::vector<RecordedScan> scans = wave(config, truth, seed);
                     Interrupt(scans);
                     return scans;
                   }});
  RoomCondition beside{"room"};
  beside.later = [](base::TruthParameters& truth, sim::Random& draw) {
    ConditionOf("second-pen-300").later(truth, draw);
    truth.effects.room.magnets.back().leaves_s = truth.effects.room.magnets.back().arrives_s = 0;
  };
  plans.push_back({kBesideFromStart, beside, wave});
  return plans;
}

// Configurations of one base, each calibrated once.
class Base {
 public:
  explicit Base(std::uint64_t seed) : seed_(seed) {}

  base::Result<Recording> Record(const Plan& plan) {
    const std::string surroundings = SurroundingsOf(plan.condition);
    if (configs_.count(surroundings) == 0) {
      auto config = ConfigIn(plan.condition, device_, seed_);
      if (!config.ok()) return base::Error{plan.name + ": " + config.error()};
      configs_.emplace(surroundings, *std::move(config));
    }
    const loop::TickConfig& config = configs_.at(surroundings);
    base::TruthParameters truth = RoomOf(plan.condition);
    sim::Random draw(seed_ ^ 0xA11);
    if (plan.condition.later) plan.condition.later(truth, draw);
    return Recording{plan.name, config.tracker, plan.record(config, truth, seed_)};
  }

 private:
  std::uint64_t seed_;
  base::DeviceGeometry device_ = FastDevice();
  std::map<std::string, loop::TickConfig> configs_;
};

// By how much a run differs: relative in mean error and median sigma; in shares of ticks.
struct Change {
  double error = 0, sigma = 0, posed = 0, silent = 0, reports = 0;

  bool none() const {
    return std::abs(error) < kSameError && std::abs(sigma) < kSameSigma && std::abs(posed) < kSameShare &&
           std::abs(silent) < kSameShare && reports < kSameShare;
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Change, error, sigma, posed, silent, reports)

Change ChangeOf(const Result& before, const Result& now) {
  const auto relative = [](double after, double was) { return was > 0 ? after / was - 1 : 0; };
  double other = 0;
  for (std::size_t i = 0; i < before.reports.size(); ++i) other += before.reports[i] != now.reports[i] ? 1 : 0;
  return {relative(now.mean_mm, before.mean_mm), relative(now.sigma_mm, before.sigma_mm), now.posed - before.posed,
          now.silent - before.silent, other / static_cast<double>(before.reports.size())};
}

// The greatest change over all recordings, each in its own.
struct Effect {
  Change most;
  std::string of_error;  // the recording

  void Add(const std::string& name, const Change& now) {
    if (std::abs(now.error) > std::abs(most.error)) of_error = name;
    for (double Change::*part : {&Change::error, &Change::sigma, &Change::posed, &Change::silent, &Change::reports}) {
      if (std::abs(now.*part) > std::abs(most.*part)) most.*part = now.*part;
    }
  }
};

using Changes = std::vector<std::array<Change, kFactors.size()>>;  // by number

// What is on trial: these numbers of the list, each by these factors.
struct Trial {
  Factors factors = kFactors;
  std::vector<std::size_t> numbers;
};

// Empty: a name is not listed.
std::vector<std::size_t> Chosen(const std::vector<TrackerNumber>& listed, const BenchOptions& options) {
  std::vector<std::size_t> chosen;
  std::istringstream names(options.numbers);
  for (std::string name; std::getline(names, name, ',');) {
    const auto at = std::find_if(listed.begin(), listed.end(), [&](const auto& number) { return number.name == name; });
    if (at == listed.end()) return {};
    chosen.push_back(static_cast<std::size_t>(at - listed.begin()));
  }
  for (std::size_t n = 0; options.numbers.empty() && n < listed.size(); n += options.quick ? 16 : 1)
    chosen.push_back(n);
  return chosen;
}

Changes Try(const Trial& trial, const Recording& recording) {
  const Result before = Track(recording, recording.config);
  Changes changes(trial.numbers.size());
  base::InParallel(changes.size(), [&](std::size_t n) {
    for (std::size_t f = 0; f < trial.factors.size(); ++f) {
      tracker::Config config = recording.config;
      Scale(trial.factors[f], TrackerNumbers(config)[trial.numbers[n]]);
      changes[n][f] = ChangeOf(before, Track(recording, config));
    }
  });
  return changes;
}

using Done = std::map<std::pair<std::uint64_t, std::string>, Changes>;  // by seed and recording

Done ReadDone(const std::string& path) {
  Done done;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    if (json.is_discarded()) break;  // of a run that was ended there
    done[{json.at("seed"), json.at("recording")}] = json.at("changes").get<Changes>();
  }
  return done;
}

}  // namespace

base::Result<BenchRows> BenchNumbers(const BenchOptions& options) {
  const auto box = PressedBox();
  if (!box.ok()) return base::Error{box.error()};
  tracker::Config plain;
  const std::vector<TrackerNumber> listed = TrackerNumbers(plain);
  Trial trial;
  if (options.factor > 0) trial.factors = {1 / options.factor, options.factor};
  trial.numbers = Chosen(listed, options);
  if (trial.numbers.empty()) return base::Error{options.numbers + ": unknown number"};
  const std::size_t count = trial.numbers.size(), bases = options.bases > 0 ? options.bases
                                                          : options.quick   ? 1
                                                                            : kBases;
  const base::DeviceGeometry device = FastDevice();
  std::vector<Plan> plans = Plans(device, *box);
  if (options.quick && options.conditions.empty()) plans.resize(4);
  if (!options.conditions.empty()) {
    std::erase_if(plans, [&](const Plan& plan) {
      return plan.condition.name != options.conditions && plan.name != options.conditions;
    });
    if (plans.empty()) return base::Error{options.conditions + ": unknown condition"};
  }
  Done done = ReadDone(options.resume);
  std::vector<std::array<Effect, kFactors.size()>> effects(count);
  for (std::size_t b = 0; b < bases; ++b) {
    const std::uint64_t seed = 1000 * options.seed + 10 * b;
    Base base(seed);
    for (const Plan& plan : plans) {
      Changes& changes = done[{seed, plan.name}];
      if (changes.size() != count) {
        const auto recording = base.Record(plan);
        if (!recording.ok()) return base::Error{recording.error()};
        changes = Try(trial, *recording);
        if (!options.resume.empty()) {
          std::ofstream(options.resume, std::ios::app)
              << nlohmann::json{{"seed", seed}, {"recording", plan.name}, {"changes", changes}} << std::endl;
        }
      }
      for (std::size_t n = 0; n < count; ++n) {
        for (std::size_t f = 0; f < trial.factors.size(); ++f) effects[n][f].Add(plan.name, changes[n][f]);
      }
    }
  }
  BenchRows rows;
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t f = 0; f < trial.factors.size(); ++f) {
      const Change& most = effects[n][f].most;
      rows.push_back({{"number", listed[trial.numbers[n]].name},
                      {"factor", trial.factors[f]},
                      {"bases", bases},
                      {"seed", options.seed},
                      {"error_change_pct", 100 * most.error},
                      {"most_in", effects[n][f].of_error},
                      {"sigma_change_pct", 100 * most.sigma},
                      {"posed_change", most.posed},
                      {"silent_change", most.silent},
                      {"reports_changed", most.reports},
                      {"no_effect", most.none()}});
    }
  }
  return rows;
}

}  // namespace omni::bench
