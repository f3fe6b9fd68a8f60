// omni-bench room: tracking outside a laboratory. Per condition ten bases, each calibrated by the whole of `omni
// calibrate` in that room, then the product's own tracker on a minute of a waved pen. A simulation: the twin makes the
// scans and judges.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/config/calibration_file.h"
#include "service/config/device_file.h"
#include "service/config/twin_file.h"
#include "service/haptics/scene.h"
#include "service/loop/tick_config.h"
#include "service/magnetics/nominal.h"
#include "service/sim/loopback.h"
#include "service/sim/ordinary_hand.h"
#include "service/sim/vec3.h"
#include "service/tools/calibrate_kept.h"
#include "service/tools/calibrate_twin.h"
#include "service/tools/statistics.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/errors.h"
#include "tests/support/trace.h"

namespace omni::bench {
namespace {

using base::TruthParameters;
using sim::operator*;
using sim::operator+;
using sim::operator-;
using sim::Random;

constexpr std::size_t kRigs = 10;
constexpr double kRun_s = 60;
constexpr double kSettle_s = 0.2;      // from no pen to the first pose, and the filter's own time
constexpr double kTracked_mm = 3;      // 3 sigma of a pose that counts as tracked
constexpr double kRecovered_s = 0.05;  // tracked for so long
constexpr double kForce_N = 0.3;       // a smaller one is not judged
constexpr double kPushed_N = 0.02;     // a larger one is felt
constexpr double kBox_m = 0.12, kBoxTop_m = 0.03;
constexpr double kFirst_s = 5;  // when what happens later does so first

// What happens to a base after its calibration; `draw` is of the rig.
using Happening = std::function<void(TruthParameters&, Random& draw)>;

struct Condition {
  std::string name;
  bool ideal = false;                           // no room
  std::function<void(TruthParameters&)> known;  // in the room already while the base is calibrated
  Happening later;
  std::vector<double> events_s = {};  // from which it has to recover
  bool as_drawn = false;              // never calibrated
};

base::Vec3 Direction(Random& draw) {
  const base::Vec3 v = draw.NormalVector(1);
  return (1 / sim::Norm(v)) * v;
}

// Ten steps, one back for each one there.
std::vector<double> StepTimes() {
  std::vector<double> times;
  for (int k = 0; k < 10; ++k) times.push_back(kFirst_s * (k + 1));
  return times;
}

Happening AmbientSteps(double size_T) {
  return [size_T](TruthParameters& truth, Random& draw) {
    base::Vec3 step_T;
    for (std::size_t k = 0; k < StepTimes().size(); ++k) {
      step_T = k % 2 == 0 ? size_T * Direction(draw) : -1.0 * step_T;
      truth.effects.room.steps.push_back({.change_base_T = step_T, .at_s = StepTimes()[k]});
    }
  };
}

// To and fro would end where it began; so it goes on turning.
Happening Turning(double rate_deg_s) {
  return [rate_deg_s](TruthParameters& truth, Random&) {
    truth.effects.room.turn_rate_rad_s = rate_deg_s * std::numbers::pi / 180;
    truth.effects.room.turn_from_s = kFirst_s;
    truth.effects.room.turn_s = kRun_s;
  };
}

base::Steel Plane(double z_m, double from_s = 0) {
  return {.shape = base::SteelShape::kPlane, .position_base_m = {0, 0, z_m}, .strength = 1, .from_s = from_s};
}

std::function<void(TruthParameters&)> SteelAt(double z_m) {
  return [z_m](TruthParameters& truth) { truth.effects.room.steel.push_back(Plane(z_m)); };
}

// Laid down within a second, on the desk.
Happening SecondPen(double distance_m) {
  return [distance_m](TruthParameters& truth, Random& draw) {
    const double angle = 2 * std::numbers::pi * draw.Uniform();
    const base::Vec3 away{std::cos(angle), std::sin(angle), 0};
    const base::MagnetGeometry& magnet = config::DefaultDevice().magnet;
    const double moment_Am2 = magnet.remanence_T * magnet.radius_m * magnet.radius_m * 2 * magnet.half_height_m / 4e-7;
    truth.effects.room.magnets.push_back({.moment_Am2 = moment_Am2 * Direction(draw),
                                          .from_base_m = 1.0 * away,
                                          .to_base_m = distance_m * away,
                                          .leaves_s = kFirst_s,
                                          .arrives_s = kFirst_s + 1});
  };
}

// Comes nearer for ten seconds, from one of five sides.
void Phone(TruthParameters& truth, Random& draw) {
  constexpr std::array<base::Vec3, 5> kSides{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0.6, 0, 0.8}}};
  const base::Vec3 side = kSides[static_cast<std::size_t>(draw.Uniform(0, 5))];
  truth.effects.room.magnets.push_back({.moment_Am2 = 0.1 * Direction(draw),
                                        .from_base_m = 0.5 * side,
                                        .to_base_m = 0.13 * side,
                                        .leaves_s = kFirst_s,
                                        .arrives_s = kFirst_s + 10});
}

Happening Faulty(base::SensorFaultKind kind, double value = 0) {
  return [kind, value](TruthParameters& truth, Random& draw) {
    const int sensor = static_cast<int>(draw.Uniform(0, base::kSensorCount));
    truth.effects.room.faults.push_back({.kind = kind,
                                         .sensor = sensor,
                                         .other = (sensor + 1) % base::kSensorCount,
                                         .value = value,
                                         .from_s = kFirst_s});
  };
}

void FiveStop(TruthParameters& truth, Random& draw) {
  const int first = static_cast<int>(draw.Uniform(0, base::kSensorCount));
  for (int k = 0; k < 5; ++k) {
    truth.effects.room.faults.push_back(
        {.kind = base::SensorFaultKind::kStopped, .sensor = (first + k) % base::kSensorCount, .from_s = kFirst_s});
  }
}

// A hull or core that is wrong by so much, and nothing else about them.
std::function<void(TruthParameters&)> Wrong(double base::ImperfectionSizes::*size, double value) {
  return [size, value](TruthParameters& truth) {
    truth.imperfections.hull_radius_m = truth.imperfections.core_offset_m = 0;
    truth.imperfections.*size = value;
  };
}

// Offsets come with a warming that the calibration has not seen, so that the base is the same one.
void OffsetsPerKelvin(TruthParameters& truth) { truth.imperfections.sensor_offset_T_K = 5e-6; }
void OneKelvin(TruthParameters& truth, Random&) { truth.effects.sensor_warming_K = 1; }

std::vector<Condition> Conditions() {
  using Kind = base::SensorFaultKind;
  using Sizes = base::ImperfectionSizes;
  const std::vector<double> once{kFirst_s};
  return {
      {"room"},
      {"ideal", true},
      {"raw-earth", true, {}, [](TruthParameters& truth, Random&) { truth.effects.background_known = false; }},
      {"as-drawn", false, {}, {}, {}, true},
      {"ambient-5uT", false, {}, AmbientSteps(5e-6), StepTimes()},
      {"ambient-20uT", false, {}, AmbientSteps(20e-6), StepTimes()},
      {"ambient-60uT", false, {}, AmbientSteps(60e-6), StepTimes()},
      {"turning-10", false, {}, Turning(10), once},
      {"turning-90", false, {}, Turning(90), once},
      {"steel-115", false, SteelAt(-0.115), {}},
      {"steel-150", false, SteelAt(-0.150), {}},
      {"steel-200", false, SteelAt(-0.200), {}},
      {"steel-300", false, SteelAt(-0.300), {}},
      {"steel-later",
       false,
       {},
       [](TruthParameters& truth, Random&) { truth.effects.room.steel.push_back(Plane(-0.2, kFirst_s)); },
       once},
      {"second-pen-300", false, {}, SecondPen(0.3), once},
      {"second-pen-200", false, {}, SecondPen(0.2), once},
      {"phone-130", false, {}, Phone, once},
      {"gain-1", false, {}, Faulty(Kind::kGain, 1.01), once},
      {"gain-3", false, {}, Faulty(Kind::kGain, 1.03), once},
      {"gain-10", false, {}, Faulty(Kind::kGain, 1.10), once},
      {"stuck", false, {}, Faulty(Kind::kStuck), once},
      {"swapped", false, {}, Faulty(Kind::kSwapped), once},
      {"huge", false, {}, Faulty(Kind::kHuge, 1e-3), once},
      {"dead-5", false, {}, FiveStop, once},
      {"offsets-50mG", false, OffsetsPerKelvin, OneKelvin},
      {"mains-5uT", false, {}, [](TruthParameters& truth, Random&) { truth.effects.room.mains_T = 5e-6; }},
      {"hull-0.3", false, Wrong(&Sizes::hull_radius_m, 3e-4), {}},
      {"core-0.5", false, Wrong(&Sizes::core_offset_m, 2.9e-4), {}},
  };
}

TruthParameters Calibrating(const Condition& condition) {
  TruthParameters truth = condition.ideal ? config::IdealTwin() : config::RoomTwin();
  if (condition.known) condition.known(truth);
  return truth;
}

struct Tally {
  std::size_t ticks = 0, tracked = 0, coarse = 0, silent = 0, refused = 0;
  std::size_t pushed_silent = 0;           // silent, and a force was wanted
  std::vector<double> error_mm, sigma_mm;  // of tracked poses
  std::vector<double> coarse_mm;           // error of coarse poses
  std::vector<double> recovery_ms, force_error_pct;
  double worst_rig_mm = 0;  // mean over all poses of a base

  void Add(const Tally& other) {
    ticks += other.ticks, tracked += other.tracked, coarse += other.coarse, silent += other.silent;
    refused += other.refused, pushed_silent += other.pushed_silent;
    const auto append = [](std::vector<double>& to, const std::vector<double>& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(error_mm, other.error_mm);
    append(sigma_mm, other.sigma_mm);
    append(coarse_mm, other.coarse_mm);
    worst_rig_mm = std::max(worst_rig_mm, other.worst_rig_mm);
    append(recovery_ms, other.recovery_ms);
    append(force_error_pct, other.force_error_pct);
  }
};

// One run against its truth.
class Judge {
 public:
  void Add(const base::ToolState& tool, const base::Vec3& true_centre_m, double force_N = 0) {
    const bool settled = static_cast<double>(tracked_.size()) * base::kTickPeriod_s >= kSettle_s;
    const bool posed = tool.status == base::TrackingStatus::kTracking;
    const double sigma_mm = 1e3 * std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]);
    const bool tracked = posed && 3 * sigma_mm <= kTracked_mm;
    tracked_.push_back(tracked || !settled);
    if (!settled) return;
    ++tally_.ticks;
    if (!posed) return;
    const double error_mm = 1e3 * sim::Norm(tool.position_base_m - true_centre_m);
    const bool silent = error_mm > kSilentSigmas * sigma_mm;
    tally_.silent += silent ? 1 : 0;
    tally_.pushed_silent += silent && force_N > kPushed_N ? 1 : 0;
    if (!tracked) {
      ++tally_.coarse;
      tally_.coarse_mm.push_back(error_mm);
      return;
    }
    ++tally_.tracked;
    tally_.error_mm.push_back(error_mm);
    tally_.sigma_mm.push_back(sigma_mm);
  }

  void AddForce(const base::Vec3& wanted_N, const base::Vec3& true_N) {
    const double size_N = sim::Norm(wanted_N);
    if (size_N >= kForce_N) tally_.force_error_pct.push_back(100 * sim::Norm(true_N - wanted_N) / size_N);
  }

  Tally Finish(const std::vector<double>& events_s) {
    const double end_s = static_cast<double>(tracked_.size()) * base::kTickPeriod_s;
    for (std::size_t e = 0; e < events_s.size() && events_s[e] < end_s; ++e) {
      const double next_s = e + 1 < events_s.size() ? std::min(events_s[e + 1], end_s) : end_s;
      tally_.recovery_ms.push_back(Recovery_ms(events_s[e], next_s));
    }
    std::vector<double> all_mm = tally_.error_mm;
    all_mm.insert(all_mm.end(), tally_.coarse_mm.begin(), tally_.coarse_mm.end());
    tally_.worst_rig_mm = all_mm.empty() ? 0 : tools::Mean(all_mm);
    return std::move(tally_);
  }

 private:
  // From the event until tracking has begun that lasts; what is lost more than a second later is no part of it. All the
  // time until the next one, if it never did.
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

  Tally tally_;
  std::vector<bool> tracked_;
};

// A box on the base, which the hand presses as it moves.
base::Result<haptics::Scene> Box() {
  haptics::InputObject box;
  box.name = "box";
  for (const double z_m : {-0.02, kBoxTop_m}) {
    box.vertices_base_m.insert(
        box.vertices_base_m.end(),
        {{-kBox_m, -kBox_m, z_m}, {kBox_m, -kBox_m, z_m}, {kBox_m, kBox_m, z_m}, {-kBox_m, kBox_m, z_m}});
  }
  box.triangles = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4},
                   {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  box.triangle_material.assign(box.triangles.size(), 0);
  haptics::SceneInput input;
  input.name = "box";
  input.materials.emplace_back();
  input.objects.push_back(std::move(box));
  haptics::BuildReport report;
  return haptics::BuildScene(input, report);
}

// The whole loop: the tick renders the box, and the hand yields to what the coils really do.
void PressBox(const base::DeviceGeometry& device, const loop::TickConfig& config, const TruthParameters& truth,
              std::uint64_t seed, std::uint64_t motion_seed, double run_s, const haptics::Scene& scene, Judge& judge) {
  sim::PlantOptions plant{.seed = seed,
                          .script = sim::MakeOrdinaryHand(device, {.seed = motion_seed + 2, .duration_s = run_s})};
  plant.truth = truth;
  sim::Loopback base(device, plant);
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  loop::EnterScene(scene, 1, *state);
  base::HallScan scan;
  sim::TruthRow before = base.core().Truth();
  for (auto ticks = static_cast<std::size_t>(run_s / base::kTickPeriod_s); ticks > 0; --ticks) {
    base.Tick(scan);
    const sim::TruthRow now = base.core().Truth();
    judge.AddForce(output->wrench.force_N, now.coil_force_N);
    const loop::Commands commands{
        .t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
    loop::Tick(config, scan, commands, scene, *state, *output);
    base.Write(output->currents);
    // The scan is of an instant between the two.
    const double share = std::clamp(static_cast<double>(scan.t_ns - before.t_ns) /
                                        static_cast<double>(std::max<std::int64_t>(1, now.t_ns - before.t_ns)),
                                    0.0, 1.0);
    judge.Add(output->tool, before.magnet_m + share * (now.magnet_m - before.magnet_m),
              sim::Norm(output->wrench.force_N));
    before = now;
  }
}

void TrackWave(const base::DeviceGeometry& device, const tracker::Config& config, const TruthParameters& truth,
               std::uint64_t seed, std::uint64_t motion_seed, double run_s, Judge& judge) {
  sim::Rig rig(device, {.seed = seed,
                        .sizes = truth.imperfections,
                        .noise = sim::NoiseMode::kLowPower,
                        .effects = truth.effects,
                        .sensor = truth.sensor});
  sim::TraceOptions options{.duration_s = run_s, .seed = motion_seed + 1};
  options.motion = {.seed = motion_seed + 2, .radius_max_m = 0.09, .tilt_max_rad = std::numbers::pi / 4};
  tracker::State state;
  base::ToolState tool;
  for (const sim::TraceRow& row : sim::RecordTrace(rig, options)) {
    tracker::Update(config, row.scan, state, tool);
    judge.Add(tool, row.pose.centre_base_m);
  }
}

// What a base is calibrated in: the same for all conditions that come later.
std::string SurroundingsOf(const Condition& condition) {
  if (condition.as_drawn) return "none";
  if (condition.known) return condition.name;
  return condition.ideal ? "ideal" : "room";
}

// As omnid has it after `omni calibrate`: from a file that one writes and the other takes. Nothing: it was refused.
std::optional<loop::TickConfig> CalibratedConfig(const base::DeviceGeometry& device, std::uint64_t seed,
                                                 const TruthParameters& truth) {
  const auto done = tools::CalibrateTwin(device, seed, truth);
  if (!done.ok()) return std::nullopt;
  const std::string text = config::WriteCalibration(tools::CalibrationFileOf(done->outcome, "twin"), device);
  const auto file = config::ParseCalibration(
      text, "room", {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = "twin"});
  if (!file.ok()) return std::nullopt;
  return loop::MakeTickConfig(device, file->calibration);
}

using Tallies = std::array<Tally, 2>;  // waved without forces, and pressing under them

// One base and the calibrations that it was given, each once.
class BaseInRooms {
 public:
  BaseInRooms(std::uint64_t seed, const haptics::Scene& scene) : seed_(seed), scene_(scene) {
    device_.sensor_noise_T = config::IdealTwin().sensor.noise_lp_T;
    configs_["none"] = loop::MakeTickConfig(device_);
  }

  // Calibrated in the surroundings of the first, then what happens in any of them.
  Tallies Run(const std::vector<const Condition*>& conditions, std::uint64_t motion_seed, double run_s) {
    TruthParameters truth = Calibrating(*conditions.front());
    const auto [config, fresh] = configs_.try_emplace(SurroundingsOf(*conditions.front()));
    if (fresh) config->second = CalibratedConfig(device_, seed_, truth);
    if (!config->second) {
      Tally refused;
      refused.ticks = static_cast<std::size_t>(run_s / base::kTickPeriod_s);
      refused.refused = 1;
      return {refused, refused};
    }
    Random draw(motion_seed ^ 0xA11);
    for (const Condition* condition : conditions) {
      if (condition->later) condition->later(truth, draw);
    }
    Judge waved, pressed;
    TrackWave(device_, config->second->tracker, truth, seed_, motion_seed, run_s, waved);
    PressBox(device_, *config->second, truth, seed_, motion_seed, run_s, scene_, pressed);
    return {waved.Finish(conditions.front()->events_s), pressed.Finish(conditions.front()->events_s)};
  }

 private:
  std::uint64_t seed_;
  const haptics::Scene& scene_;
  base::DeviceGeometry device_ = config::DefaultDevice();
  std::map<std::string, std::optional<loop::TickConfig>> configs_;
};

// Two conditions at once, chosen at random for every run. Only safety is required of them.
constexpr std::string_view kPairs = "pairs";
constexpr std::size_t kPairsPerRig = 10;
constexpr double kPairRun_s = 12;

std::vector<const Condition*> DrawPair(const std::vector<Condition>& all, Random& draw) {
  for (;;) {
    const Condition& first = all[static_cast<std::size_t>(draw.Uniform(0, static_cast<double>(all.size())))];
    const Condition& second = all[static_cast<std::size_t>(draw.Uniform(0, static_cast<double>(all.size())))];
    // What only differs from the room by being ideal, or happens before the calibration already, is no second.
    if (first.ideal || first.as_drawn || second.ideal || second.as_drawn || !second.later) continue;
    if (first.name != second.name) return {&first, &second};
  }
}

Tallies RunPairs(BaseInRooms& base, std::uint64_t seed, std::size_t pairs) {
  const std::vector<Condition> all = Conditions();
  Random draw(seed ^ 0xBA12);
  Tallies sums;
  for (std::size_t p = 0; p < pairs; ++p) {
    const Tallies done = base.Run(DrawPair(all, draw), seed + 1 + p, kPairRun_s);
    for (std::size_t f = 0; f < sums.size(); ++f) sums[f].Add(done[f]);
  }
  for (Tally& sum : sums) sum.recovery_ms.clear();  // of one of the two only
  return sums;
}

nlohmann::ordered_json Row(const std::string& condition, bool force, const Tally& tally, std::size_t rigs,
                           std::uint64_t seed) {
  const auto share = [&](std::size_t n) { return static_cast<double>(n) / static_cast<double>(tally.ticks); };
  const auto measured = [](const std::vector<double>& values, double value) {
    return values.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(value);
  };
  const std::size_t poses = tally.tracked + tally.coarse;
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
          {"force_error_p95_pct", measured(tally.force_error_pct, tools::Quantile(tally.force_error_pct, 0.95))},
          {"calibrations_refused", tally.refused}};
}

}  // namespace

base::Result<BenchRows> BenchRoom(const BenchOptions& options) {
  std::vector<Condition> conditions = Conditions();
  const bool pairs = options.condition.empty() || options.condition == kPairs;
  if (!options.condition.empty()) {
    std::erase_if(conditions, [&](const Condition& c) { return c.name != options.condition; });
    if (conditions.empty() && !pairs) return base::Error{options.condition + ": there is no such condition"};
  }
  const std::size_t rigs = options.quick ? 2 : kRigs;
  const double run_s = options.quick ? 12 : kRun_s;
  const auto scene = Box();
  if (!scene.ok()) return base::Error{scene.error()};
  std::vector<std::string> names;
  for (const Condition& condition : conditions) names.push_back(condition.name);
  if (pairs) names.emplace_back(kPairs);
  std::vector<std::vector<Tallies>> done(rigs);
  base::InParallel(rigs, [&](std::size_t r) {
    const std::uint64_t seed = 1000 * options.seed + 10 * r;
    BaseInRooms base(seed, *scene);
    for (const Condition& condition : conditions) done[r].push_back(base.Run({&condition}, seed, run_s));
    if (pairs) done[r].push_back(RunPairs(base, seed, options.quick ? 2 : kPairsPerRig));
  });
  BenchRows rows;
  for (const bool force : {false, true}) {
    for (std::size_t c = 0; c < names.size(); ++c) {
      Tally sum;
      for (std::size_t r = 0; r < rigs; ++r) sum.Add(done[r][c][force ? 1 : 0]);
      rows.push_back(Row(names[c], force, sum, rigs, options.seed));
    }
  }
  return rows;
}

}  // namespace omni::bench
