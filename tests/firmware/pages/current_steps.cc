#include "tests/firmware/pages/current_steps.h"

#include <algorithm>
#include <cmath>

#include "tests/firmware/pages/fixed_text.h"

namespace omni::firmware {

StepAnswer MeasureStep(const StepCase& step, int coil) {
  FirmwarePlant::Options options;
  options.supply_V = step.supply_V;
  options.start_C = step.copper_C;
  options.resistance_error = step.settings_error;
  options.inductance_error = -3 * step.settings_error;
  FirmwareBench bench({}, options);
  StepAnswer answer;
  if (!bench.RunToArmed()) {
    answer.faults = bench.core.faults();
    return answer;
  }
  bench.RunMs(10);
  double at_10_ms = -1, at_90_ms = -1, largest_A = 0, sum_A = 0, t_ms = 0;
  int count = 0;
  bench.each_step = [&] {
    const double current_A = bench.plant.current_A(coil);
    t_ms += 0.25;
    largest_A = std::max(largest_A, current_A);
    if (at_10_ms < 0 && current_A >= 0.1 * step.target_A) at_10_ms = t_ms;
    if (at_90_ms < 0 && current_A >= 0.9 * step.target_A) at_90_ms = t_ms;
    if (t_ms <= 30 || t_ms > 50) return;
    sum_A += current_A;
    ++count;
  };
  bench.set_point_A[coil] = static_cast<float>(step.target_A);
  bench.SendCommand();
  bench.RunMs(50);
  answer.rise_ms = at_90_ms - at_10_ms;
  answer.overshoot = largest_A / step.target_A - 1;
  answer.steady_error = std::abs(sum_A / count / step.target_A - 1);
  answer.faults = bench.core.faults();
  return answer;
}

HeatingRun MeasureHeating() {
  constexpr int kCoil = 1;
  constexpr double kTarget_A = 5;
  HeatingRun run;
  FirmwareBench bench;
  bench.RunToArmed();
  bench.set_point_A[kCoil] = static_cast<float>(kTarget_A);
  bench.RunMs(100);
  for (int second = 0; second < 15 * 60; ++second) {
    bench.RunMs(1000);
    const CoilHeat& heat = bench.core.heat();
    const double tracked_ohm = static_cast<double>(heat.resistance_ohm(kCoil));
    const double by_resistance_C = static_cast<double>(heat.by_resistance_C(kCoil));
    run.current_error = std::max(run.current_error, std::abs(bench.plant.current_A(kCoil) / kTarget_A - 1));
    run.resistance_error =
        std::max(run.resistance_error, std::abs(tracked_ohm / bench.plant.resistance_ohm(kCoil) - 1));
    run.temperature_error_K =
        std::max(run.temperature_error_K, std::abs(by_resistance_C - bench.plant.temperature_C(kCoil)));
  }
  run.copper_C = bench.plant.temperature_C(kCoil);
  run.faults = bench.core.faults();
  return run;
}

const std::vector<StepCase>& PageSteps() {
  static const std::vector<StepCase> kSteps = [] {
    std::vector<StepCase> steps;
    for (const double error : {0.0, 0.03, -0.03}) {
      for (const double target_A : {5.0, 15.0}) {
        for (const double supply_V : {12.0, 18.0}) {
          // 12 V give 15 A up to 47 C of the coil with the most resistance; a coil that is believed hotter than 60 C
          // shrinks its current.
          const double hot_C = supply_V < 15 ? 40 : 47;
          for (const double copper_C : {24.0, hot_C}) steps.push_back({target_A, supply_V, copper_C, error});
        }
      }
    }
    return steps;
  }();
  return kSteps;
}

std::string StepPage(const HeatingRun& heating) {
  std::string page =
      "# Step responses\n\nPrinted by the target `current_steps`: the control core of `firmware/core` on a "
      "simulated base "
      "in virtual time, whose\ncurrent sensors read 0.15 % and 2 mA too much. A test checks it. True currents, the "
      "worst of "
      "three coils. `coil`: how far\nits resistance is from the settings; its inductance is three times as far the "
      "other "
      "way.\n\n"
      "| step, A | supply, V | copper, C | coil, % | rise 10-90 %, ms | overshoot, % | steady error, % |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const StepCase& step : PageSteps()) {
    StepAnswer worst;
    worst.overshoot = -1;
    for (int coil = 0; coil < wire::kCoils; ++coil) {
      const StepAnswer answer = MeasureStep(step, coil);
      worst.rise_ms = std::max(worst.rise_ms, answer.rise_ms);
      worst.overshoot = std::max(worst.overshoot, answer.overshoot);
      worst.steady_error = std::max(worst.steady_error, answer.steady_error);
    }
    page += "| 0 to " + Fixed(step.target_A, 0) + " | " + Fixed(step.supply_V, 0) + " | " + Fixed(step.copper_C, 0) +
            " | " + Fixed(100 * step.settings_error, 0) + " | " + Fixed(worst.rise_ms, 2) + " | " +
            Fixed(100 * std::max(worst.overshoot, 0.0), 2) + " | " + Fixed(100 * worst.steady_error, 2) + " |\n";
  }
  page += "\n5 A through coil y for 15 minutes, from 24 C to " + Fixed(heating.copper_C, 1) +
          " C of copper: current within " + Fixed(100 * heating.current_error, 2) + " %, tracked resistance within " +
          Fixed(100 * heating.resistance_error, 2) + " %,\ntemperature by resistance within " +
          Fixed(heating.temperature_error_K, 1) + " K.\n";
  return page;
}

}  // namespace omni::firmware
