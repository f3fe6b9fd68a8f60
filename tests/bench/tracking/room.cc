// omni-bench room: tracking outside a laboratory. Per condition ten bases, each calibrated by the whole of `omni
// calibrate` in that room, then the product's own tracker on a minute of a waved pen. A simulation: the twin makes the
// scans and is the reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick_config.h"
#include "service/sim/fields/vec3.h"
#include "service/tools/common/row_table.h"
#include "service/tools/scene/scene.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/harness/room_conditions.h"
#include "tests/bench/tracking/pressed_box.h"
#include "tests/support/hand/ordinary_hand.h"
#include "tests/support/rig/trace.h"
#include "tests/support/touch/fresh_scene.h"

namespace omni::bench {
namespace {

using base::TruthParameters;
using sim::Random;

constexpr std::size_t kRigs = 10;
constexpr double kSettle_s = 0.2;      // from no pen to the first pose, and for the filter to settle
constexpr double kTracked_mm = 3;      // 3 sigma of a pose that counts as tracked
constexpr double kRecovered_s = 0.05;  // tracked for so long
constexpr double kForce_N = 0.3;       // a smaller one is not judged
constexpr double kPushed_N = 0.02;     // a larger one can be felt
constexpr double kAbove_s = 1;         // as-drawn: the pen rests above the base at first
constexpr const char* kPlayedScenes[] = {"extrusion", "dragon", "racetrack"};

struct Tally {
  std::size_t ticks = 0, tracked = 0, coarse = 0, refused = 0;
  std::size_t poses = 0, silent = 0;       // also before a condition's settle_s
  std::size_t pushed_silent = 0;           // silent, and a force was requested
  std::vector<double> error_mm, sigma_mm;  // of tracked poses
  std::vector<double> coarse_mm;           // error of coarse poses
  std::vector<double> recovery_ms;
  std::vector<double> force_error_pct;  // of ticks with a force
  std::size_t limited = 0;              // of these: cut by a limit
  double worst_rig_mm = 0;              // mean over all poses of a base

  void Add(const Tally& other) {
    ticks += other.ticks, tracked += other.tracked, coarse += other.coarse, refused += other.refused;
    poses += other.poses, silent += other.silent, pushed_silent += other.pushed_silent;
    Append(other.error_mm, error_mm);
    Append(other.sigma_mm, sigma_mm);
    Append(other.coarse_mm, coarse_mm);
    Append(other.recovery_ms, recovery_ms);
    Append(other.force_error_pct, force_error_pct);
    limited += other.limited;
    worst_rig_mm = std::max(worst_rig_mm, other.worst_rig_mm);
  }
};

// One run against its truth.
class Judge {
 public:
  explicit Judge(double settle_s) : settle_s_(std::max(settle_s, kSettle_s)) {}

  void Add(const base::ToolState& tool, const base::Vec3& true_centre_m, double force_N = 0) {
    const double t_s = static_cast<double>(tracked_.size()) * base::kTickPeriod_s;
    const bool settled = t_s >= settle_s_;
    const bool posed = tool.status == base::TrackingStatus::kTracking;
    const double sigma_mm = 1e3 * std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]);
    const bool tracked = posed && 3 * sigma_mm <= kTracked_mm;
    tracked_.push_back(tracked || !settled);
    if (!(t_s >= kSettle_s)) return;
    tally_.ticks += settled ? 1 : 0;
    if (!posed) return;
    const double error_mm = 1e3 * base::Norm(tool.position_base_m - true_centre_m);
    const bool silent = error_mm > kSilentSigmas * sigma_mm;
    ++tally_.poses;
    tally_.silent += silent ? 1 : 0;
    tally_.pushed_silent += silent && force_N > kPushed_N ? 1 : 0;
    if (!settled) return;
    if (!tracked) {
      ++tally_.coarse;
      tally_.coarse_mm.push_back(error_mm);
      return;
    }
    ++tally_.tracked;
    tally_.error_mm.push_back(error_mm);
    tally_.sigma_mm.push_back(sigma_mm);
  }

  // The force on the pen, core's pull included, against the one that the loop says is made.
  void AddForce(const base::Vec3& said_N, const base::Vec3& true_N, bool limited) {
    const double size_N = base::Norm(said_N);
    if (!(size_N >= kForce_N)) return;
    tally_.force_error_pct.push_back(100 * base::Norm(true_N - said_N) / size_N);
    tally_.limited += limited ? 1 : 0;
  }

  Tally Finish(const std::vector<double>& events_s) {
    const double end_s = static_cast<double>(tracked_.size()) * base::kTickPeriod_s;
    for (std::size_t e = 0; e < events_s.size() && events_s[e] < end_s; ++e) {
      const double next_s = e + 1 < events_s.size() ? std::min(events_s[e + 1], end_s) : end_s;
      tally_.recovery_ms.push_back(Recovery_ms(events_s[e], next_s));
    }
    std::vector<double> all_mm = tally_.error_mm;
    Append(tally_.coarse_mm, all_mm);
    tally_.worst_rig_mm = all_mm.empty() ? 0 : tools::Mean(all_mm);
    return std::move(tally_);
  }

 private:
  // From the event until stable tracking resumes; losses more than a second later do not count. If it never does, the
  // whole time until the next event.
  double Recovery_ms(double from_s, double to_s) const {
    const auto tick_at = [&](double t_s) {
      return std::min(tracked_.size(), static_cast<std::size_t>(t_s / base::kTickPeriod_s));
    };
    const std::size_t from = tick_at(from_s), to = tick_at(to_s), lasting = tick_at(kRecovered_s);
    std::size_t run = 0, lost = 0;
    for (std::size_t i = from; i < to; ++i) {
      run = tracked_[i] ? run + 1 : 0;
      if (run == 0) lost = i + 1;
      if (run >= lasting && i >= from + tick_at(1.0)) break;
    }
    return lost == 0 ? 0 : 1e3 * base::kTickPeriod_s * static_cast<double>(lost - from);
  }

  const double settle_s_;
  Tally tally_;
  std::vector<bool> tracked_;
};

// The force on the pen, judged as it acts; the pose, as it is published.
void PressJudged(const base::DeviceGeometry& device, const loop::TickConfig& config, const TruthParameters& truth,
                 std::uint64_t seed, const sim::HandScript& hand, double run_s, const haptics::Scene& scene,
                 Judge& judge) {
  Press(device, config, truth, seed, hand, run_s, scene, [&](const PressedTick& tick) {
    judge.AddForce(tick.before.wrench.force_N, tick.truth.force_N, tick.before.saturated);
    judge.Add(tick.output.tool, tick.magnet_base_m, base::Norm(tick.output.wrench.force_N));
  });
}

void TrackWave(const base::DeviceGeometry& device, const tracker::Config& config, const TruthParameters& truth,
               std::uint64_t seed, std::uint64_t motion_seed, double run_s, Judge& judge) {
  sim::Rig rig(device, sim::OptionsOf(seed, sim::NoiseMode::kLowPower, truth));
  sim::TraceOptions options{.duration_s = run_s, .seed = motion_seed + 1};
  options.motion = {.seed = motion_seed + 2, .radius_max_m = 0.09, .tilt_max_rad = std::numbers::pi / 4};
  tracker::State state;
  base::ToolState tool;
  for (const sim::TraceRow& row : sim::RecordTrace(rig, options)) {
    tracker::Update(config, row.scan, state, tool);
    judge.Add(tool, row.pose.centre_base_m);
  }
}

constexpr std::string_view kScenePrefix = "scene-";

struct PlayedScene {
  std::string name;  // of the condition
  haptics::Scene scene;
  sim::HandScript hand;
};

base::Result<PlayedScene> LoadPlayed(const std::string& scene) {
  const std::string path = tools::ShippedScene(scene);
  auto loaded = tools::LoadLiveScene(path, {});
  if (!loaded.ok()) return base::Error{loaded.error()};
  auto hand = sim::LoadHandScript(tools::FindHandScript(path));
  if (!hand.ok()) return base::Error{hand.error()};
  hand->repeat = true;
  return PlayedScene{std::string(kScenePrefix) + scene, std::move(loaded->scene), *std::move(hand)};
}

using Tallies = std::array<Tally, 2>;  // waved without forces, and pressing under them

// One base and its calibrations, each made once.
class BaseInRooms {
 public:
  BaseInRooms(std::uint64_t seed, const haptics::Scene& scene) : seed_(seed), scene_(scene) {}

  // Calibrated in the surroundings of the first, then with the events of all of them.
  Tallies Run(const std::vector<const RoomCondition*>& conditions, std::uint64_t motion_seed, double run_s) {
    TruthParameters truth = RoomOf(*conditions.front());
    const auto [config, fresh] = configs_.try_emplace(SurroundingsOf(*conditions.front()));
    if (fresh) config->second = ConfigIn(*conditions.front(), device_, seed_);
    if (!config->second->ok()) {
      Tally refused;
      refused.ticks = static_cast<std::size_t>(run_s / base::kTickPeriod_s);
      refused.refused = 1;
      return {refused, refused};
    }
    Random draw(motion_seed ^ 0xA11);
    for (const RoomCondition* condition : conditions) {
      if (condition->later) condition->later(truth, draw);
    }
    Judge waved(conditions.front()->settle_s), pressed(conditions.front()->settle_s);
    TrackWave(device_, (**config->second).tracker, truth, seed_, motion_seed, run_s, waved);
    // Who starts an uncalibrated base holds the pen above it.
    const sim::OrdinaryHandOptions hand{
        .seed = motion_seed + 2, .duration_s = run_s, .above_s = conditions.front()->as_drawn ? kAbove_s : 0};
    PressJudged(device_, **config->second, truth, seed_, sim::MakeOrdinaryHand(device_, hand), run_s, scene_, pressed);
    return {waved.Finish(conditions.front()->events_s), pressed.Finish(conditions.front()->events_s)};
  }

  // In the room that every base is calibrated in, its hand plays a shipped scene again and again.
  Tally RunScene(const PlayedScene& played, double run_s) {
    static const RoomCondition kRoom{"room"};
    const auto [config, fresh] = configs_.try_emplace(SurroundingsOf(kRoom));
    if (fresh) config->second = ConfigIn(kRoom, device_, seed_);
    Judge judge(0);
    if (!config->second->ok()) {
      Tally refused;
      refused.ticks = static_cast<std::size_t>(run_s / base::kTickPeriod_s);
      refused.refused = 1;
      return refused;
    }
    const haptics::Scene scene = test::FreshCopy(played.scene);
    PressJudged(device_, **config->second, RoomOf(kRoom), seed_, played.hand, run_s, scene, judge);
    return judge.Finish({});
  }

 private:
  std::uint64_t seed_;
  const haptics::Scene& scene_;
  base::DeviceGeometry device_ = FastDevice();
  std::map<std::string, std::optional<base::Result<loop::TickConfig>>> configs_;
};

// Two conditions at once, chosen at random for every run. Only safety is required of them.
constexpr std::string_view kPairs = "pairs";
constexpr std::size_t kPairsPerRig = 10;
constexpr double kPairRun_s = 12;

std::vector<const RoomCondition*> DrawPair(const std::vector<RoomCondition>& all, Random& draw) {
  for (;;) {
    const RoomCondition& first = all[static_cast<std::size_t>(draw.Uniform(0, static_cast<double>(all.size())))];
    const RoomCondition& second = all[static_cast<std::size_t>(draw.Uniform(0, static_cast<double>(all.size())))];
    // Conditions that are ideal, or whose effects begin before the calibration, cannot be the second.
    if (first.ideal || first.as_drawn || second.ideal || second.as_drawn || !second.later) continue;
    if (first.name != second.name) return {&first, &second};
  }
}

Tallies RunPairs(BaseInRooms& base, std::uint64_t seed, std::size_t pairs) {
  std::vector<RoomCondition> all = RoomConditions();
  std::erase_if(all, [](const RoomCondition& c) { return c.settle_s > 0; });  // another pen
  Random draw(seed ^ 0xBA12);
  Tallies sums;
  for (std::size_t p = 0; p < pairs; ++p) {
    const Tallies done = base.Run(DrawPair(all, draw), seed + 1 + p, kPairRun_s);
    for (std::size_t f = 0; f < sums.size(); ++f) sums[f].Add(done[f]);
  }
  for (Tally& sum : sums) sum.recovery_ms.clear();  // would be those of only one of the two
  return sums;
}

nlohmann::ordered_json Row(const std::string& condition, bool force, const Tally& tally, std::size_t rigs,
                           std::uint64_t seed) {
  const auto share = [&](std::size_t n) { return static_cast<double>(n) / static_cast<double>(tally.ticks); };
  const auto measured = [](const std::vector<double>& values, double value) {
    return values.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(value);
  };
  const std::size_t poses = tally.poses;
  const std::size_t pushes = tally.force_error_pct.size();
  return {{"condition", condition},
          {"force", force},
          {"rigs", rigs},
          {"ticks", tally.ticks},
          {"seed", seed},
          {"tracked_fraction", share(tally.tracked)},
          {"coarse_fraction", share(tally.coarse)},
          {"mean_mm", measured(tally.error_mm, tools::Mean(tally.error_mm))},
          {"p95_mm", measured(tally.error_mm, tools::Quantile(tally.error_mm, 0.95))},
          {"sigma_mm", measured(tally.sigma_mm, tools::Quantile(tally.sigma_mm, 0.5))},
          {"silent_fraction",
           poses == 0 ? nlohmann::ordered_json(nullptr)
                      : nlohmann::ordered_json(static_cast<double>(tally.silent) / static_cast<double>(poses))},
          {"pushed_silent_fraction",
           force && poses > 0
               ? nlohmann::ordered_json(static_cast<double>(tally.pushed_silent) / static_cast<double>(poses))
               : nlohmann::ordered_json(nullptr)},
          {"coarse_mean_mm", measured(tally.coarse_mm, tools::Mean(tally.coarse_mm))},
          {"worst_rig_mm", poses == 0 ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(tally.worst_rig_mm)},
          {"recovery_ms_p95", measured(tally.recovery_ms, tools::Quantile(tally.recovery_ms, 0.95))},
          {"force_error_p50_pct", measured(tally.force_error_pct, tools::Quantile(tally.force_error_pct, 0.5))},
          {"force_error_p95_pct", measured(tally.force_error_pct, tools::Quantile(tally.force_error_pct, 0.95))},
          {"limited_fraction",
           pushes == 0 ? nlohmann::ordered_json(nullptr)
                       : nlohmann::ordered_json(static_cast<double>(tally.limited) / static_cast<double>(pushes))},
          {"calibrations_refused", tally.refused}};
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream rest(text);
  for (std::string word; std::getline(rest, word, ',');) words.push_back(word);
  return words;
}

}  // namespace

base::Result<BenchRows> BenchRoom(const BenchOptions& options) {
  std::vector<RoomCondition> conditions = RoomConditions();
  const std::vector<std::string> wanted = SplitAtCommas(options.conditions);
  std::set<std::string> known{std::string(kPairs)};
  for (const RoomCondition& condition : conditions) known.insert(condition.name);
  for (const char* scene : kPlayedScenes) known.insert(std::string(kScenePrefix) + scene);
  for (const std::string& name : wanted) {
    if (known.count(name) == 0) return base::Error{name + ": unknown condition"};
  }
  const auto is_wanted = [&](std::string_view name) {
    return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
  };
  std::erase_if(conditions, [&](const RoomCondition& c) { return !is_wanted(c.name); });
  std::vector<PlayedScene> scenes;
  for (const char* name : kPlayedScenes) {
    if (!is_wanted(std::string(kScenePrefix) + name)) continue;
    auto played = LoadPlayed(name);
    if (!played.ok()) return base::Error{played.error()};
    scenes.push_back(std::move(*played));
  }
  const bool pairs = is_wanted(kPairs);
  const std::size_t rigs = options.quick ? 2 : kRigs;
  const double run_s = options.quick ? 12 : kRoomRun_s;
  const auto box = PressedBox();
  if (!box.ok()) return base::Error{box.error()};
  std::vector<std::string> names;
  for (const RoomCondition& condition : conditions) names.push_back(condition.name);
  if (pairs) names.emplace_back(kPairs);
  std::vector<std::vector<Tallies>> done(rigs);
  std::vector<std::vector<Tally>> in_scenes(rigs);
  base::InParallel(rigs, [&](std::size_t r) {
    const std::uint64_t seed = 1000 * options.seed + 10 * r;
    BaseInRooms base(seed, *box);
    for (const RoomCondition& condition : conditions) done[r].push_back(base.Run({&condition}, seed, run_s));
    if (pairs) done[r].push_back(RunPairs(base, seed, options.quick ? 2 : kPairsPerRig));
    for (const PlayedScene& scene : scenes) in_scenes[r].push_back(base.RunScene(scene, run_s));
  });
  BenchRows rows;
  const auto add = [&](const std::string& name, bool force, const auto& tally_of) {
    Tally sum;
    for (std::size_t r = 0; r < rigs; ++r) sum.Add(tally_of(r));
    rows.push_back(Row(name, force, sum, rigs, options.seed));
  };
  for (const bool force : {false, true}) {
    for (std::size_t c = 0; c < names.size(); ++c) {
      add(names[c], force, [&](std::size_t r) -> const Tally& { return done[r][c][force ? 1 : 0]; });
    }
  }
  for (std::size_t c = 0; c < scenes.size(); ++c) {
    add(scenes[c].name, true, [&](std::size_t r) -> const Tally& { return in_scenes[r][c]; });
  }
  return rows;
}

}  // namespace omni::bench
