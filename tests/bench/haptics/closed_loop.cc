#include "tests/bench/haptics/closed_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "service/base/limits.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick.h"
#include "service/sim/fields/vec3.h"
#include "service/sim/twin/loopback.h"
#include "tests/bench/harness/room_conditions.h"
#include "tests/support/touch/virtual_wall.h"

namespace omni::bench {
namespace {

constexpr std::size_t kRigs = 4;
constexpr std::array<double, 2> kRadii_m{0.055, 0.09};
constexpr double kHold_s = 4, kAbove_m = 8e-3, kDepth_m = 5e-3;
constexpr double kBuzzFrom_Hz = 30;
constexpr std::size_t kJudged = 1000;  // ticks, the last ones

// Motion of a hand at a wall.
struct Situation {
  const char* name;
  double mass_kg, damping_Ns_m, stiffness_N_m;
  double tremor_m = 0;
  double wall_damping_Ns_m = 0;
  bool taps = false, drops = false;
  double scans_late = 0, scans_lost = 0;
};

constexpr Situation kSituations[] = {
    {"press", 0.12, 3, 150},
    {"damping wall", 0.12, 3, 150, 0, 2},
    {"taps", 0.12, 3, 150, 0, 0, true},
    {"tremor", 0.12, 3, 150, 2e-4},
    {"leaning, 10 g", 0.01, 0.1, 150},
    {"dropped, 20 g", 0.02, 0.1, 20, 0, 0, false, true},
    {"late scans", 0.12, 3, 150, 0, 0, false, false, 0.1, 0.02},
};

sim::HandScript ScriptOf(const Situation& situation, double wall_z_m) {
  sim::HandScript script{.name = situation.name,
                         .stiffness_N_m = situation.stiffness_N_m,
                         .damping_Ns_m = situation.damping_Ns_m,
                         .mass_kg = situation.mass_kg,
                         .tremor_m = situation.tremor_m};
  const auto at = [&](double above_m) { return base::Vec3{0, 0, wall_z_m + above_m}; };
  script.waypoints = {{.duration_s = 0, .tip_base_m = at(kAbove_m)}, {.duration_s = 2, .tip_base_m = at(kAbove_m)}};
  const auto go = [&](double duration_s, double above_m) {
    script.waypoints.push_back({.duration_s = duration_s, .tip_base_m = at(above_m)});
  };
  for (int tap = 0; situation.taps && tap < 16; ++tap) {
    go(0.12, -kDepth_m);
    go(0.12, kAbove_m);
  }
  go(situation.drops ? 0.02 : 0.5, -kDepth_m);
  go(kHold_s + 1, -kDepth_m);
  return script;
}

struct Felt {
  double buzz_mN = 0, swing_mm = 0, peak_N = 0, given_mJ = 0, gain = 1, offered_N_m = 0;
  std::size_t contact_ticks = 0;
};

Felt Touch(const base::DeviceGeometry& device, const loop::TickConfig& config, base::TruthParameters truth,
           std::uint64_t seed, double radius_m, const Situation& situation) {
  const double wall_z_m = radius_m - device.magnet.tip_offset_m;
  truth.effects.room.scan_late = situation.scans_late;
  truth.effects.room.scan_lost = situation.scans_lost;
  sim::PlantOptions plant{.seed = seed, .script = ScriptOf(situation, wall_z_m)};
  plant.truth = truth;
  const haptics::Scene scene =
      test::Wall(wall_z_m, {.stiffness_N_m = 2000, .damping_Ns_m = situation.wall_damping_Ns_m});
  std::vector<double> force_N, tip_m;
  Felt felt;
  const loop::Commands commands{.gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
  RunTwin(device, config, plant, scene, commands, [&](const sim::TruthRow& row, const loop::TickOutput& output) {
    force_N.push_back(base::Norm(row.coil_force_N));
    tip_m.push_back(row.tip_m.z);
    felt.peak_N = std::max(felt.peak_N, force_N.back());
    felt.given_mJ += 1e3 * base::kTickPeriod_s * base::Dot(row.coil_force_N, row.velocity_m_s);
    felt.gain = std::min(felt.gain, output.haptics.energy_gain);
    felt.contact_ticks += output.haptics.contact_count > 0;
    felt.offered_N_m = output.haptics.stiffness_offered_N_m;
  });
  felt.buzz_mN = 1e3 * test::RmsAbove(force_N, force_N.size() - 2 * kJudged, force_N.size(), kBuzzFrom_Hz);
  felt.swing_mm = 1e3 * test::RmsAboutMean(tip_m, tip_m.size() - kJudged, tip_m.size());
  return felt;
}

}  // namespace

void RunTwin(const base::DeviceGeometry& device, const loop::TickConfig& config, const sim::PlantOptions& plant,
             const haptics::Scene& scene, loop::Commands commands,
             const std::function<void(const sim::TruthRow&, const loop::TickOutput&)>& each_tick) {
  sim::Loopback twin(device, plant);
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  loop::EnterScene(scene, commands.scene_generation, *state);
  base::HallScan scan;
  for (auto tick = static_cast<int>((plant.script.duration_s() - 1) / base::kTickPeriod_s); tick > 0; --tick) {
    twin.Tick(scan);
    commands.t_ns = scan.t_ns;
    loop::Tick(config, scan, commands, scene, *state, *output);
    twin.Write(output->currents);
    each_tick(twin.core().Truth(), *output);
  }
}

base::Result<BenchRows> ClosedLoop(std::uint64_t seed, bool quick) {
  const std::size_t rigs = quick ? 1 : kRigs;
  const base::DeviceGeometry device = FastDevice();
  BenchRows rows;
  for (const bool in_room : {false, true}) {
    const RoomCondition condition{.name = in_room ? "room" : "ideal", .ideal = !in_room};
    std::vector<std::vector<Felt>> of_rig(rigs);
    const auto touch = [&](std::size_t r, std::uint64_t rig_seed, const loop::TickConfig& config) {
      for (const double radius_m : kRadii_m) {
        for (const Situation& situation : kSituations) {
          of_rig[r].push_back(Touch(device, config, RoomOf(condition), rig_seed, radius_m, situation));
        }
      }
    };
    if (auto error = OnRigs(condition, device, rigs, 1000 * seed + 500, touch)) return *error;
    for (std::size_t k = 0; k < of_rig[0].size(); ++k) {
      Felt worst = of_rig[0][k];
      std::size_t force_cut = 0;
      for (const auto& felts : of_rig) {
        const Felt& felt = felts[k];
        worst.buzz_mN = std::max(worst.buzz_mN, felt.buzz_mN);
        worst.swing_mm = std::max(worst.swing_mm, felt.swing_mm);
        worst.peak_N = std::max(worst.peak_N, felt.peak_N);
        worst.given_mJ = std::max(worst.given_mJ, felt.given_mJ);
        worst.offered_N_m = std::min(worst.offered_N_m, felt.offered_N_m);
        worst.contact_ticks = std::min(worst.contact_ticks, felt.contact_ticks);
        force_cut += felt.gain < 1;
      }
      const std::size_t n = std::size(kSituations);
      rows.push_back({{"table", "closed-loop"},
                      {"room", in_room},
                      {"radius_mm", 1e3 * kRadii_m[k / n]},
                      {"situation", kSituations[k % n].name},
                      {"rigs", rigs},
                      {"buzz_mN", worst.buzz_mN},
                      {"swing_mm", worst.swing_mm},
                      {"peak_N", worst.peak_N},
                      {"given_mJ", worst.given_mJ},
                      {"force_cut", force_cut},
                      {"offered_N_m", worst.offered_N_m},
                      {"contact_ticks", worst.contact_ticks}});
    }
  }
  return rows;
}

}  // namespace omni::bench
