// Every fault in every state: time until the base reports it, until the currents are gone, and the remaining current.
// And a host that falls silent, at several currents.
#pragma once

#include <string>
#include <vector>

#include "firmware/wire/messages.h"

namespace omni::firmware {

// The state of the base when a fault occurs.
struct Situation {
  wire::State state;
  float current_A;  // in all coils, where it is armed
  const char* name;
};
constexpr Situation kSituations[] = {
    {wire::State::kBoot, 0, "boot"},        {wire::State::kSelfTest, 0, "self-test"}, {wire::State::kIdle, 0, "idle"},
    {wire::State::kArmed, 5, "armed, 5 A"}, {wire::State::kArmed, 15, "armed, 15 A"}, {wire::State::kFault, 0, "fault"},
};

struct MatrixCell {
  Situation situation;
  bool happens = false;  // false: the fault cannot occur in this state
  bool detected = false;
  double detected_ms = 0;  // from the cause to the fault bit
  double zero_ms = 0;      // from the cause until every coil stays below kZero_A
  double left_A = 0;       // largest current of a coil kAfter_ms after the bit
  bool resting = false;    // by then the bridges sleep and all duties are 0
};

struct MatrixRow {
  wire::Fault fault = wire::kFaultInternal;
  std::string cause;
  std::vector<MatrixCell> cells;  // in the order of kSituations
};

// A host's last COMMAND, at one current in all coils.
struct SilenceRow {
  float current_A = 0;
  std::vector<double> zero_ms;  // from that COMMAND until every coil stays below kZero_A; in the order of kSupplies_V
  double left_A = 0;            // of any of them, kAfter_ms later
};

constexpr double kZero_A = 0.05;
constexpr double kAfter_ms = 100;
constexpr double kSupplies_V[] = {12, 18, 24};

std::vector<MatrixRow> MeasureFaultMatrix();
std::vector<SilenceRow> MeasureSilence();

// docs/protocol/faults.md
std::string FaultPage(const std::vector<MatrixRow>& rows, const std::vector<SilenceRow>& silence);

}  // namespace omni::firmware
