// omni-bench hands: walls under hands that press in rhythm, tremble, slide over ridges and tap, through the whole tick
// on the digital twin. An ordinary hand keeps its wall.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/base/limits.h"
#include "service/sim/fields/random.h"
#include "tests/bench/haptics/closed_loop.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/room_conditions.h"
#include "tests/support/touch/virtual_wall.h"

namespace omni::bench {
namespace {

constexpr double kAbove_m = 8e-3, kRadius_m = 0.055;
constexpr double kArrive_s = 2, kTouch_s = 0.5;
constexpr double kDeep_m = 1e-3;       // a shallower tip says little about stiffness
constexpr std::size_t kMean = 50;      // ticks, of a stiffness
constexpr std::size_t kBefore = 400;   // ticks from the first touch: what it was before
constexpr std::size_t kLostFor = 500;  // ticks
constexpr double kLostShare = 0.5;

struct Motion {
  std::string name;
  double press_m = 0, press_Hz = 0, tremor_m = 0;
  sim::TremorBand band;
  double slide_m_s = 0;
  double depth_m = 5e-3, mass_kg = 0.12;
};

std::vector<Motion> Motions(bool quick) {
  std::vector<Motion> motions;
  for (const double rate_Hz : {1, 2, 3, 4, 5, 6, 7, 8}) {
    for (const double press_m : {1e-3, 2e-3})
      motions.push_back({.name = "press", .press_m = press_m, .press_Hz = rate_Hz});
  }
  for (const sim::TremorBand band : {sim::TremorBand{4, 6}, {6, 8}, {8, 12}, {4, 12}}) {
    for (const double tremor_m : {5e-4, 1e-3, 2e-3, 3e-3}) {
      motions.push_back({.name = "tremor", .tremor_m = tremor_m, .band = band});
    }
  }
  for (const double rate_Hz : {2, 4, 6}) {
    motions.push_back({.name = "both", .press_m = 1.5e-3, .press_Hz = rate_Hz, .tremor_m = 5e-4, .band = {4, 12}});
  }
  for (const double speed_m_s : {0.02, 0.05, 0.1}) {
    motions.push_back({.name = "ridges", .tremor_m = 2e-4, .slide_m_s = speed_m_s});
  }
  for (const double mass_kg : {0.1, 0.2}) {
    for (const double rate_Hz : {2, 4, 6, 8}) {
      motions.push_back({.name = "taps", .press_m = 4e-3, .press_Hz = rate_Hz, .depth_m = 5e-4, .mass_kg = mass_kg});
    }
  }
  if (quick) {
    std::vector<Motion> few;
    for (std::size_t i = 0; i < motions.size(); i += 7) few.push_back(motions[i]);
    return few;
  }
  return motions;
}

// A sine of the hand's rest position, as minimum-jerk half waves.
sim::HandScript ScriptOf(const Motion& motion, double hand_N_m, double wall_z_m, double hold_s) {
  sim::HandScript script{.name = motion.name,
                         .stiffness_N_m = hand_N_m,
                         .damping_Ns_m = 0.01 * hand_N_m + 1,
                         .mass_kg = motion.mass_kg,
                         .tremor_m = motion.tremor_m,
                         .tremor_band = motion.band};
  double x_m = motion.slide_m_s > 0 ? -0.01 : 0;
  const auto go = [&](double duration_s, double above_m) {
    script.waypoints.push_back({.duration_s = duration_s, .tip_base_m = {x_m, 0, wall_z_m + above_m}});
  };
  go(0, kAbove_m);
  go(kArrive_s, kAbove_m);
  go(kTouch_s, -motion.depth_m);
  go(kTouch_s, -motion.depth_m);
  double held_s = 0;
  double side = 1;
  while (held_s < hold_s && (motion.press_Hz > 0 || motion.slide_m_s > 0)) {
    const double half_s = motion.press_Hz > 0 ? 0.5 / motion.press_Hz : 0.02 / motion.slide_m_s;
    if (motion.slide_m_s > 0) x_m = 0.01 * side;
    go(half_s, -motion.depth_m - side * motion.press_m);
    side = -side;
    held_s += half_s;
  }
  go(std::max(1.0, hold_s + 1 - held_s), -motion.depth_m);
  return script;
}

struct Kept {
  double least_share = 1;  // of the stiffness before
  bool lost = false, softened = false;
};

// Stiffness by the twin's record: force of the coils over the depth of the true tip; negative where it says nothing.
std::vector<double> Smooth(const std::vector<double>& stiffness_N_m) {
  std::vector<double> smooth(stiffness_N_m.size(), -1);
  double sum = 0;
  std::size_t in_row = 0;
  for (std::size_t i = 0; i < stiffness_N_m.size(); ++i) {
    if (stiffness_N_m[i] < 0) {
      sum = 0;
      in_row = 0;
      continue;
    }
    sum += stiffness_N_m[i];
    if (++in_row > kMean) sum -= stiffness_N_m[i - kMean];
    if (in_row >= kMean) smooth[i] = sum / static_cast<double>(kMean);
  }
  return smooth;
}

Kept Judge(const std::vector<double>& measured_N_m, const std::vector<double>& gain) {
  const std::vector<double> stiffness_N_m = Smooth(measured_N_m);
  Kept kept;
  std::vector<double> first;
  for (const double value : stiffness_N_m) {
    if (value >= 0 && first.size() < kBefore) first.push_back(value);
  }
  double before_N_m = 0;
  if (!first.empty()) {
    std::nth_element(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(first.size() / 2), first.end());
    before_N_m = first[first.size() / 2];
  }
  const auto weak = [&](std::size_t i) { return stiffness_N_m[i] >= 0 && stiffness_N_m[i] < kLostShare * before_N_m; };
  for (std::size_t i = 0; i < gain.size(); ++i) {
    kept.softened = kept.softened || gain[i] < 1;
    if (stiffness_N_m[i] >= 0) kept.least_share = std::min(kept.least_share, stiffness_N_m[i] / before_N_m);
    if (i < kLostFor) continue;
    kept.lost =
        kept.lost || (weak(i) && weak(i - kLostFor)) || (gain[i] < kLostShare && gain[i - kLostFor] < kLostShare);
  }
  return kept;
}

struct Case {
  Motion motion;
  double hand_N_m = 0;
  bool constraint = false;  // touched; else a surface
};

haptics::Constraint Plane(double z_m) {
  return {.kind = haptics::ConstraintKind::kPlane,
          .side = haptics::ConstraintSide::kOutside,
          .stiffness_N_m = 2000,
          .max_force_N = 2,
          .point_base_m = {0, 0, z_m},
          .direction_base = {0, 0, 1}};
}

Kept Hold(const base::DeviceGeometry& device, const loop::TickConfig& config, const base::TruthParameters& truth,
          std::uint64_t seed, const Case& touch, double hold_s) {
  const auto& [motion, hand_N_m, constraint] = touch;
  const double wall_z_m = kRadius_m - device.magnet.tip_offset_m;
  sim::PlantOptions plant{.seed = seed, .script = ScriptOf(motion, hand_N_m, wall_z_m, hold_s)};
  plant.truth = truth;
  const bool ridges = motion.slide_m_s > 0;
  const haptics::Material material{.stiffness_N_m = 2000};
  const haptics::Scene scene = constraint ? haptics::Scene()
                               : ridges   ? test::Ridges(wall_z_m, 4e-3, 1e-3, material)
                                          : test::Wall(wall_z_m, material);
  loop::Commands commands{.gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
  if (constraint) {
    commands.applied.open = true;
    commands.applied.constraints_id = 1;
    commands.applied.constraint_count = 1;
    commands.applied.constraints[0] = Plane(wall_z_m);
  }
  std::vector<double> stiffness_N_m, gain;
  RunTwin(device, config, plant, scene, commands, [&](const sim::TruthRow& row, const loop::TickOutput& output) {
    const double depth_m = wall_z_m - row.tip_m.z;
    const bool says = !ridges && depth_m > kDeep_m && !output.saturated && output.gate == 1;
    stiffness_N_m.push_back(says ? row.coil_force_N.z / depth_m : -1);
    gain.push_back(loop::ContactGain(output));
  });
  return Judge(stiffness_N_m, gain);
}

std::vector<Case> Cases(bool quick) {
  const std::vector<double> hands_N_m =
      quick ? std::vector<double>{400} : std::vector<double>{100, 150, 200, 300, 400, 500};
  std::vector<Case> cases;
  for (const Motion& motion : Motions(quick)) {
    for (const double hand_N_m : hands_N_m) {
      cases.push_back({motion, hand_N_m, false});
      if (motion.slide_m_s == 0) cases.push_back({motion, hand_N_m, true});
    }
  }
  return cases;
}

struct Total {
  int runs = 0, lost = 0, softened = 0;
  double least_share = 1;
};

}  // namespace

base::Result<BenchRows> BenchHands(const BenchOptions& options) {
  const base::DeviceGeometry device = FastDevice();
  const double hold_s = options.quick ? 2 : 4;
  const RoomCondition room{.name = "room"};
  const std::vector<Case> cases = Cases(options.quick);
  std::vector<Kept> kept(cases.size());
  const auto touch = [&](std::size_t, std::uint64_t seed, const loop::TickConfig& config) {
    const base::TruthParameters truth = RoomOf(room);
    base::InParallel(cases.size(),
                     [&](std::size_t i) { kept[i] = Hold(device, config, truth, seed, cases[i], hold_s); });
  };
  if (auto error = OnRigs(room, device, 1, 1000 * options.seed + 700, touch)) return *error;
  std::map<std::pair<std::string, bool>, Total> totals;
  BenchRows lost;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Motion& motion = cases[i].motion;
    Total& total = totals[{motion.name, cases[i].constraint}];
    ++total.runs;
    total.lost += kept[i].lost;
    total.softened += kept[i].softened;
    total.least_share = std::min(total.least_share, kept[i].least_share);
    if (!kept[i].lost) continue;
    lost.push_back({{"table", "lost"},
                    {"motion", motion.name},
                    {"constraint", cases[i].constraint},
                    {"hand_N_m", cases[i].hand_N_m},
                    {"mass_kg", motion.mass_kg},
                    {"press_mm", 1e3 * motion.press_m},
                    {"press_Hz", motion.press_Hz},
                    {"tremor_mm", 1e3 * motion.tremor_m},
                    {"from_Hz", motion.band.from_Hz},
                    {"to_Hz", motion.band.to_Hz},
                    {"least_share", kept[i].least_share}});
  }
  BenchRows rows;
  for (const auto& [key, total] : totals) {
    rows.push_back({{"motion", key.first},
                    {"touched", key.second ? "constraint" : "surface"},
                    {"runs", total.runs},
                    {"lost", total.lost},
                    {"softened", total.softened},
                    {"least_share", total.least_share},
                    {"seed", options.seed}});
  }
  rows.insert(rows.end(), lost.begin(), lost.end());
  return rows;
}

}  // namespace omni::bench
