// Every fault in every state: how long until the base says so, until the currents are gone, and what is left of them.
#pragma once

#include <string>
#include <vector>

#include "firmware/wire/messages.h"

namespace omni::firmware {

struct MatrixCell {
  wire::State state = wire::State::kBoot;
  bool happens = false;  // false: this state cannot see this fault
  bool detected = false;
  double detected_ms = 0;  // from the cause to the fault bit
  double zero_ms = 0;      // from the cause until every coil stays below 50 mA
  double left_A = 0;       // largest current of a coil 100 ms after the bit
  bool resting = false;    // by then the bridges sleep and no duty is given
};

struct MatrixRow {
  wire::Fault fault = wire::kFaultInternal;
  std::string cause;
  std::vector<MatrixCell> cells;  // boot, self-test, idle, armed, fault
};

// All coils at 5 A where armed, one at 1 A in the self-test.
std::vector<MatrixRow> MeasureFaultMatrix();

// docs/protocol/faults.md
std::string FaultPage(const std::vector<MatrixRow>& rows);

}  // namespace omni::firmware
