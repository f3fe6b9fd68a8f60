// omni bench thermal: the paper's two heat runs on the twin, and in the host's model fed with the twin's measured
// currents; then all coils at full current for 15 minutes under the host's derating. The twin's constants are those
// that the paper's three temperatures fix. peak_C, peak_s and end_C are the body's, where the paper's thermometer was;
// the copper's own, which it could not see, stand beside them.
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "service/actuation/actuation.h"
#include "service/config/device_file.h"
#include "service/sim/coil_bank.h"
#include "service/tools/bench.h"

namespace omni::tools {
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
  void Take(double value_C, double t_s) {
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
    coils.Set(wanted_A);
    coils.Heat(kStep_s);
    const double end_s = t_s + kStep_s;
    both.twin.body.Take(coils.body_C(), end_s);
    both.twin.copper.Take(*std::max_element(coils.temperature_C().begin(), coils.temperature_C().end()), end_s);
    both.host.body.Take(host.heat.body_C, end_s);
    both.host.copper.Take(*std::max_element(host.heat.copper_C.begin(), host.heat.copper_C.end()), end_s);
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

}  // namespace

base::Result<BenchRows> BenchThermal(const BenchOptions&) {
  BenchRows rows;
  for (const Run& run : kRuns) {
    const base::DeviceGeometry& device = config::DefaultDevice();
    const Both both = Simulate(device, run);
    rows.push_back(Row(run, "twin", both.twin));
    rows.push_back(Row(run, "host", both.host));
  }
  return rows;
}

}  // namespace omni::tools
