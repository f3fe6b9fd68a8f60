// omni-bench thermal: the paper's two heat runs on the twin, and in the host's model fed with the twin's measured
// currents; then all coils at full current for 15 minutes under the host's derating. The twin's constants are those
// that the paper's three temperatures fix. peak_C, peak_s and end_C are the body's, where the paper's thermometer was;
// those of the copper, which it could not measure, have their own columns.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "service/actuation/actuation.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/sim/coils/coil_bank.h"
#include "service/sim/twin/loopback.h"
#include "tests/bench/harness/bench.h"

namespace omni::bench {
namespace {

constexpr double kStep_s = 1e-3;
constexpr std::int64_t kStep_ns = 1'000'000;

// coil y at `current_A` for `on_s`, then off; or all three as much as the host allows.
struct Run {
  const char* name;
  double current_A;
  double on_s;
  double length_s;
  bool derated;
};
constexpr Run kRuns[] = {{"15 A 25 s", 15, 25, 300, false},
                         {"5 A 15 min", 5, 900, 900, false},
                         {"3 x 15 A asked for 15 min, derated", 15, 900, 900, true}};

struct Peak {
  double peak_C = -1e9;
  double peak_s = 0;
  double end_C = 0;
  void Add(double value_C, double t_s) {
    end_C = value_C;
    if (value_C <= peak_C) return;
    peak_C = value_C;
    peak_s = t_s;
  }
};

struct Curves {
  Peak body, copper;  // copper: the hottest coil
  double current_min_A = 1e9, current_step_A = 0;
};

struct Both {
  Curves twin, host;
};

Both Simulate(const base::DeviceGeometry& device, const Run& run) {
  const actuation::Config config = actuation::MakeConfig(device);
  sim::CoilBank coils(device, {});  // without a trip: the paper's base had only its thermometer
  actuation::State host;
  Both both;
  double last_A = 0;
  const auto steps = static_cast<std::int64_t>(run.length_s / kStep_s);
  for (std::int64_t i = 0; i < steps; ++i) {
    const double t_s = static_cast<double>(i) * kStep_s;
    base::HallScan scan;
    scan.t_ns = i * kStep_ns;
    scan.coil_current_A = coils.current_A();
    scan.coil_temperature_C.fill(config.heat.nodes.air_C);  // the host's model is on its own
    scan.supply_V = device.supply_V;
    actuation::UpdateHeat(config, scan, host);

    sim::CoilArray wanted_A{};
    if (t_s < run.on_s) {
      wanted_A = {0, run.current_A, 0};
      if (run.derated) {
        for (std::size_t k = 0; k < 3; ++k) wanted_A[k] = std::min(run.current_A, host.heat.current_max_A[k]);
      }
    }
    both.host.current_min_A = std::min(both.host.current_min_A, wanted_A[1]);
    if (i > 0 && t_s < run.on_s) {
      both.host.current_step_A = std::max(both.host.current_step_A, std::abs(wanted_A[1] - last_A));
    }
    last_A = wanted_A[1];
    host.last_current_A = wanted_A;
    coils.SetCurrents(wanted_A);
    coils.StepHeat(kStep_s);
    const double end_s = t_s + kStep_s;
    both.twin.body.Add(coils.body_C(), end_s);
    both.twin.copper.Add(*std::max_element(coils.temperature_C().begin(), coils.temperature_C().end()), end_s);
    both.host.body.Add(host.heat.body_C, end_s);
    both.host.copper.Add(*std::max_element(host.heat.copper_C.begin(), host.heat.copper_C.end()), end_s);
  }
  both.twin.current_min_A = both.host.current_min_A;
  both.twin.current_step_A = both.host.current_step_A;
  return both;
}

nlohmann::ordered_json Row(const Run& run, const char* model, const Curves& curves) {
  return {{"run", run.name},
          {"model", model},
          {"peak_C", curves.body.peak_C},
          {"peak_s", curves.body.peak_s},
          {"end_C", curves.body.end_C},
          {"copper_peak_C", curves.copper.peak_C},
          {"copper_peak_s", curves.copper.peak_s},
          {"copper_end_C", curves.copper.end_C},
          {"current_end_A", run.on_s < run.length_s ? 0 : curves.current_min_A},
          {"current_step_max_A", curves.current_step_A}};
}

// The paper's constant-force run on the whole twin: control core, drifting resistance, a magnet that warms in the hand.
// The pen is held in a vice, its tip 20 mm above the hull.
nlohmann::ordered_json ConstantForce(const base::DeviceGeometry& device, std::size_t coil, std::uint64_t seed) {
  constexpr double kHeld_A = 5, kSettled_s = 1;
  constexpr int kHeldTicks = 900'000;
  sim::PlantOptions options;
  options.seed = seed;
  options.truth = config::IdealTwin();
  options.script.waypoints = {{.tip_base_m = {0, 0, device.hull_radius_m + 0.020}}};
  options.script.stiffness_N_m = 1e5;
  options.script.damping_Ns_m = 200;
  sim::Loopback twin(device, options);
  base::CoilCurrents wanted;
  wanted.current_A[coil] = kHeld_A;
  base::HallScan scan;
  double first_N = 0, force_worst = 0, current_worst = 0, copper_C = 0;
  for (int i = 0; i < kHeldTicks; ++i) {
    twin.Write(wanted);
    twin.Tick(scan);
    const double t_s = i * base::kTickPeriod_s;
    if (t_s < kSettled_s || i % 100 != 0) continue;
    const sim::TruthRow row = twin.core().Truth();
    const double force_N = base::Norm(row.coil_force_N);
    if (first_N == 0) first_N = force_N;
    force_worst = std::max(force_worst, std::abs(force_N / first_N - 1));
    const double current_A = twin.core().plant().current_A()[coil];
    current_worst = std::max(current_worst, std::abs(current_A / kHeld_A - 1));
    copper_C = twin.core().plant().temperature_C()[coil];
  }
  return {{"table", "constant force"},
          {"coil", coil == 1 ? "y" : "z"},
          {"held_A", kHeld_A},
          {"minutes", kHeldTicks * base::kTickPeriod_s / 60},
          {"force_N", first_N},
          {"force_worst_pct", 100 * force_worst},
          {"current_worst_pct", 100 * current_worst},
          {"copper_end_C", copper_C},
          {"faults", scan.device_faults}};
}

}  // namespace

base::Result<BenchRows> BenchThermal(const BenchOptions& options) {
  BenchRows rows;
  for (const Run& run : kRuns) {
    const base::DeviceGeometry& device = config::DefaultDevice();
    const Both both = Simulate(device, run);
    rows.push_back(Row(run, "twin", both.twin));
    rows.push_back(Row(run, "host", both.host));
  }
  for (const std::size_t coil : {1U, 2U}) rows.push_back(ConstantForce(config::DefaultDevice(), coil, options.seed));
  return rows;
}

}  // namespace omni::bench
