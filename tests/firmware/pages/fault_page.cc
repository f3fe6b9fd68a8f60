// docs/protocol/faults.md: the rules of the code and the measurements.
#include <algorithm>

#include "firmware/core/safety/fault_rules.h"
#include "firmware/wire/names.h"
#include "service/device/commands.h"
#include "tests/firmware/pages/fault_matrix.h"
#include "tests/firmware/pages/fixed_text.h"

namespace omni::firmware {
namespace {

const char* ReactionText(Reaction reaction) {
  switch (reaction) {
    case Reaction::kNone:
      return "none";
    case Reaction::kRamp:
      return "ramp";
    case Reaction::kBrake:
      return "brake";
  }
  return "";
}

std::string HoldText(const FaultRule& rule) {
  if (rule.fault == wire::kFaultNotArmed || rule.fault == wire::kFaultWatchdog) return "-";
  if (rule.fault == wire::kFaultHostSilent) return "time to live";
  if (rule.fault == wire::kFaultHallStuck) return std::to_string(rule.hold) + " repeats";
  if (rule.fault == wire::kFaultHallJump) return std::to_string(rule.hold) + " samples";
  if (rule.hold == 1) return "1 step";
  return Fixed(rule.hold * 0.25, rule.hold % kStepsPerMs == 0 ? 0 : 1) + " ms";
}

std::string RetestText(const FaultRule& rule) {
  if (rule.fault == wire::kFaultNotArmed || rule.fault == wire::kFaultWatchdog) return "nothing more";
  if (rule.fault == wire::kFaultHostSilent) return "a live COMMAND";
  if (rule.retest == (kRetestHall | kRetestCoils)) return "self-test";
  if (rule.retest == kRetestHall) return "Hall self-test";
  if (rule.retest == kRetestCoils) return "coil self-test";
  return "cause gone";
}

std::string RuleTable() {
  std::string text = "| fault | means | hold | coils | ARM wants |\n|---|---|---|---|---|\n";
  for (const FaultRule& rule : kFaultRules) {
    const wire::FaultText* words = wire::FindFault(rule.fault);
    text += std::string("| ") + words->name + " | " + words->meaning + " | " + HoldText(rule) + " | " +
            ReactionText(rule.reaction) + " | " + RetestText(rule) + " |\n";
  }
  return text;
}

std::string CellText(const MatrixCell& cell) {
  if (!cell.happens) return " - |";
  if (!cell.detected) return " never |";
  return " " + Fixed(cell.detected_ms, 2) + " / " + Fixed(cell.zero_ms, 2) + " |";
}

std::string MatrixTable(const std::vector<MatrixRow>& rows) {
  std::string text = "| fault | cause |";
  std::string line = "|---|---|";
  for (const Situation& situation : kSituations) {
    text += std::string(" ") + situation.name + " |";
    line += "---|";
  }
  text += " left, mA |\n" + line + "---|\n";
  for (const MatrixRow& row : rows) {
    text += std::string("| ") + wire::FaultName(row.fault) + " | " + row.cause + " |";
    double left_A = 0;
    for (const MatrixCell& cell : row.cells) {
      left_A = std::max(left_A, cell.left_A);
      text += CellText(cell);
    }
    text += " " + Fixed(1000 * left_A, 0) + " |\n";
  }
  return text;
}

std::string SilenceTable(const std::vector<SilenceRow>& rows) {
  std::string text = "| all coils at |";
  std::string line = "|---|";
  for (const double supply_V : kSupplies_V) {
    text += " " + Fixed(supply_V, 0) + " V |";
    line += "---|";
  }
  text += " left, mA |\n" + line + "---|\n";
  for (const SilenceRow& row : rows) {
    text += "| " + Fixed(static_cast<double>(row.current_A), 0) + " A |";
    for (const double zero_ms : row.zero_ms) text += " " + Fixed(zero_ms, 2) + " |";
    text += " " + Fixed(1000 * row.left_A, 0) + " |\n";
  }
  return text;
}

}  // namespace

std::string FaultPage(const std::vector<MatrixRow>& rows, const std::vector<SilenceRow>& silence) {
  return R"(# Faults

Printed by the target `fault_matrix` from `firmware/core/safety/fault_rules.h`, `firmware/wire/names.h` and runs of the control
core against a simulated base in virtual time. A test checks it. How to fix each fault: `wire.md`.

## Rules

`hold`: how long the condition must last. `coils`: what then happens to their currents. `ramp`: to zero within 5 ms, then
brake; `brake`: at once, windings shorted; after 10 ms of braking the bridges sleep. `none`: no reaction is needed, because
coils are not driven before ARM, or have been at rest since the reset. A fault stays set until ARM finds the condition in
the last column. ARM starts the self-test and is refused until it has passed.

)" + RuleTable() +
         R"(
## Reactions

Per state, in ms from the cause: until the fault bit / until every coil stays below )" +
         Fixed(1000 * kZero_A, 0) + R"( mA (0.00: none had more). Supply 18 V;
armed: that current in all three coils; self-test: 1 A in the coil under test. `left`: the largest current of any coil
in any of these runs )" +
         Fixed(kAfter_ms, 0) +
         R"( ms after the bit; the bridges sleep by then. `-`: the fault cannot occur in this state.

)" + MatrixTable(rows) +
         R"(
Notes. `not armed` is not a failure but the state of a base before ARM: the bit is always set, set-points have no effect, and
a running self-test continues to its end. The core waits for a sensor that is dead at boot, so the self-test that it fails
comes later than its cause. `all copper at 85 C`: currents shrink with the measured temperature before the bit is set.
`the fan stops` at boot and in the self-test: the ms until zero are those of the self-test, which continues until the bit is
set. `bridges are driven by mistake`: for the first 2 ms they wake, braking. `the firmware hangs`: duties stay as they are
until the watchdog of the Teensy's board resets it; after a reset the bridges brake for at least 10 ms (firmware/README.md),
and the self-test that follows ends in the state fault.

## Silence

The host gives every current )" +
         std::to_string(device::kCommandTimeToLive_ms) +
         R"( ms to live (service/device/commands.h). In ms from its last COMMAND until every coil stays
below )" +
         Fixed(1000 * kZero_A, 0) + R"( mA, by supply:

)" + SilenceTable(silence);
}

}  // namespace omni::firmware
