// The core's current response to steps and its stability over minutes, measured on the simulated base.
#pragma once

#include <string>
#include <vector>

#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {

struct StepCase {
  double target_A = 0;
  double supply_V = 0;
  double copper_C = 0;
  double settings_error = 0;  // resistance of the coils is so much more than in the settings, inductance 3 times less
};

struct StepAnswer {
  double rise_ms = 0;       // 10 to 90 %
  double overshoot = 0;     // of the true current, share; below 0: it stays below
  double steady_error = 0;  // share, mean over 20 ms, 30 ms after the step
  std::uint32_t faults = 0;
};

StepAnswer MeasureStep(const StepCase& step, int coil);

// 5 A through coil y for 15 minutes, from 24 C.
struct HeatingRun {
  double copper_C = 0;             // at the end
  double current_error = 0;        // largest, share
  double resistance_error = 0;     // of the tracked one, largest, share
  double temperature_error_K = 0;  // by resistance, largest
  std::uint32_t faults = 0;
};
HeatingRun MeasureHeating();

// The steps of docs/theory/firmware-steps.md.
const std::vector<StepCase>& PageSteps();
// That page; the worst of the three coils each.
std::string StepPage(const HeatingRun& heating);

}  // namespace omni::firmware
