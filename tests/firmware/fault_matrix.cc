#include "tests/firmware/fault_matrix.h"

#include <algorithm>

#include "firmware/wire/names.h"
#include "tests/firmware/fixed_text.h"
#include "tests/support/firmware_bench.h"

namespace omni::firmware {
namespace {

using wire::State;

constexpr double kZero_A = 0.05;
constexpr float kArmed_A = 5;
constexpr double kWatch_ms = 4000;
constexpr double kAfter_ms = 100;
constexpr std::uint32_t kAnywhere = 0x1F;
constexpr std::uint32_t In(State state) { return 1U << static_cast<int>(state); }

struct Cause {
  wire::Fault fault;
  const char* text;
  std::uint32_t states;  // bits: where it can be seen
  void (*happen)(FirmwareBench&);
};

const Cause kCauses[] = {
    {wire::kFaultHostSilent, "commands end", In(State::kArmed), [](FirmwareBench& b) { b.host_speaks = false; }},
    {wire::kFaultOverTemperature, "board at 90 C", kAnywhere, [](FirmwareBench& b) { b.plant.faults.board_C = 90; }},
    {wire::kFaultOverTemperature, "all copper at 85 C at once", In(State::kArmed),
     [](FirmwareBench& b) { b.plant.SetTemperature(85); }},
    {wire::kFaultOverCurrent, "a sensor reads 16 A", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.current_reading_A = 16; }},
    {wire::kFaultDriver, "a bridge says so", kAnywhere, [](FirmwareBench& b) { b.plant.faults.driver = true; }},
    {wire::kFaultSupplyLow, "8 V", kAnywhere & ~In(State::kBoot), [](FirmwareBench& b) { b.plant.SetSupply(8); }},
    {wire::kFaultSupplyHigh, "28 V", kAnywhere, [](FirmwareBench& b) { b.plant.SetSupply(28); }},
    {wire::kFaultPower, "voltages read 1.6 times", In(State::kArmed),
     [](FirmwareBench& b) { b.plant.faults.voltage_reading = 1.6; }},
    {wire::kFaultCoilOpen, "a coil's wire breaks", In(State::kSelfTest) | In(State::kArmed),
     [](FirmwareBench& b) { b.plant.faults.coil_open = true; }},
    {wire::kFaultCoilShort, "nine tenths of a coil shorted", In(State::kSelfTest) | In(State::kArmed),
     [](FirmwareBench& b) { b.plant.faults.coil_short = true; }},
    {wire::kFaultModel, "a bridge chops at 2 A", In(State::kArmed),
     [](FirmwareBench& b) { b.plant.faults.current_limit_A = 2; }},
    {wire::kFaultCurrentSensor, "a sensor does not answer", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.current_sensor_dead = true; }},
    {wire::kFaultHallSensor, "a sensor does not answer", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.hall_dead = true; }},
    {wire::kFaultHallStuck, "a sensor repeats its sample", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.hall_stuck = true; }},
    {wire::kFaultHallJump, "a sensor jumps by 12 G", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.hall_jump = true; }},
    {wire::kFaultFan, "the fan stands", kAnywhere, [](FirmwareBench& b) { b.plant.faults.fan_stands = true; }},
    {wire::kFaultEmergencyStop, "the switch opens", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.emergency_stop = true; }},
    {wire::kFaultEmergencyStop, "ESTOP", kAnywhere, [](FirmwareBench& b) { b.Send(wire::Estop{}); }},
    {wire::kFaultSelfTest, "a sensor shows no test field", In(State::kBoot),
     [](FirmwareBench& b) { b.plant.faults.test_field_dead = true; }},
    {wire::kFaultInternal, "the clock stands", kAnywhere, [](FirmwareBench& b) { b.plant.faults.clock_stands = true; }},
};

// Brings a base into a state; the self-test at its coil 1, kFault by another fault than the one to come.
void Bring(FirmwareBench& bench, State state, wire::Fault coming) {
  if (state == State::kBoot) return bench.RunMs(2);
  if (state == State::kSelfTest) {
    while (bench.outputs.duty[1] == 0) bench.Step();
    return bench.RunMs(10);
  }
  bench.RunUntil(State::kIdle, 1000);
  bench.RunMs(500);  // the fan has come to speed
  if (state == State::kIdle) return;
  bench.Arm();
  bench.SetAll(kArmed_A);
  bench.RunMs(50);
  if (state == State::kArmed) return;
  if (coming == wire::kFaultEmergencyStop) {
    bench.plant.SetSupply(8);
    bench.RunMs(50);
    bench.plant.SetSupply(18);
  } else {
    bench.Send(wire::Estop{});
  }
  bench.RunMs(100);
}

MatrixCell Measure(const Cause& cause, State state) {
  Settings settings;
  settings.power_max_W = 60;  // so that three coils at 5 A are near it
  FirmwareBench bench(settings);
  Bring(bench, state, cause.fault);
  MatrixCell cell;
  cell.state = state;
  cell.happens = true;
  cause.happen(bench);
  double after_ms = 0;
  for (double ms = 0; ms < kWatch_ms && after_ms < kAfter_ms; ms += 0.25) {
    if (!cell.detected && (bench.core.faults() & cause.fault) != 0) {
      cell.detected = true;
      cell.detected_ms = ms;
    }
    if (bench.plant.largest_A() > kZero_A) cell.zero_ms = ms + 0.25;
    if (cell.detected) after_ms += 0.25;
    bench.Step();
  }
  cell.left_A = bench.plant.largest_A();
  const Outputs& out = bench.outputs;
  cell.resting = out.awake == 0 && out.duty[0] == 0 && out.duty[1] == 0 && out.duty[2] == 0;
  return cell;
}

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
  if (rule.fault == wire::kFaultHostSilent) return "time to live";
  if (rule.fault == wire::kFaultHallStuck || rule.fault == wire::kFaultHallJump) {
    return std::to_string(rule.hold) + " samples";
  }
  if (rule.hold == 1) return "1 step";
  return Fixed(rule.hold * 0.25, rule.hold % 4 == 0 ? 0 : 1) + " ms";
}

std::string RetestText(const FaultRule& rule) {
  if (rule.retest == (kRetestHall | kRetestCoils)) return "self-test";
  if (rule.retest == kRetestHall) return "Hall self-test";
  if (rule.retest == kRetestCoils) return "coil self-test";
  return "cause gone";
}

}  // namespace

std::vector<MatrixRow> MeasureFaultMatrix() {
  std::vector<MatrixRow> rows;
  for (const Cause& cause : kCauses) {
    MatrixRow row;
    row.fault = cause.fault;
    row.cause = cause.text;
    for (int i = 0; i <= static_cast<int>(State::kFault); ++i) {
      const State state = static_cast<State>(i);
      MatrixCell cell;
      cell.state = state;
      if ((cause.states & In(state)) != 0) cell = Measure(cause, state);
      row.cells.push_back(cell);
    }
    rows.push_back(row);
  }
  return rows;
}

std::string FaultPage(const std::vector<MatrixRow>& rows) {
  std::string page =
      "# Faults\n\nPrinted by the target `fault_matrix` from `firmware/core/fault_rules.h` and from runs of the "
      "control "
      "core against a\nsimulated base in virtual time. A test compares.\n\n"
      "## Rules\n\n`hold`: how long the condition must last. `ramp`: currents to zero within 5 ms, then brake; "
      "`brake`: at "
      "once, windings\nshorted. 10 ms of braking later the bridges sleep. A fault stays until ARM finds what the last "
      "column says; a self-test is\nstarted by ARM, which is refused until it has passed.\n\n"
      "| fault | hold | coils | ARM wants |\n|---|---|---|---|\n";
  for (const FaultRule& rule : kFaultRules) {
    page += std::string("| ") + wire::FaultName(rule.fault) + " | " + HoldText(rule) + " | " +
            ReactionText(rule.reaction) + " | " + RetestText(rule) + " |\n";
  }
  page +=
      "\n## Reactions\n\nPer state in ms from the cause: until the fault bit / until every coil stays below 50 mA (0: "
      "none "
      "had more). Armed: 5 A in\nall coils at 18 V; self-test: 1 A in the coil that is tried. `left`: the largest "
      "current "
      "of any coil and state 100 ms after\nthe bit; the bridges sleep by then. `-`: this state cannot see it.\n\n"
      "| fault | cause | boot | self-test | idle | armed | fault | left, mA |\n|---|---|---|---|---|---|---|---|\n";
  for (const MatrixRow& row : rows) {
    page += std::string("| ") + wire::FaultName(row.fault) + " | " + row.cause + " |";
    double left_A = 0;
    for (const MatrixCell& cell : row.cells) {
      left_A = std::max(left_A, cell.left_A);
      if (!cell.happens) {
        page += " - |";
      } else if (!cell.detected) {
        page += " never |";
      } else {
        page += " " + Fixed(cell.detected_ms, 2) + " / " + Fixed(cell.zero_ms, 2) + " |";
      }
    }
    page += " " + Fixed(1000 * left_A, 0) + " |\n";
  }
  page +=
      "\n`not armed` is no failure but the state of a base that nobody has armed. `watchdog` is known at boot from the "
      "reset's\ncause, and so is a fault record that did not survive it (`internal`); both end the self-test in the "
      "state "
      "fault.\n";
  return page;
}

}  // namespace omni::firmware
