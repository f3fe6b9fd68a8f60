#include "tests/firmware/pages/fault_matrix.h"

#include <algorithm>

#include "firmware/board/teensy40/chip/chip.h"
#include "tests/support/chips/firmware_bench.h"
#include "tests/support/rig/core_tamper.h"

namespace omni::firmware {
namespace {

using wire::State;

constexpr double kStep_ms = 1.0 / kStepsPerMs;
constexpr double kWatch_ms = 4000;
constexpr double kWatchdog_ms = board::kWatchdogTimeout_us * 1e-3;
constexpr float kPowerShare = 1.25F;  // limit of all coils together: this far above what they take
constexpr float kSilenceCurrents_A[] = {1, 5, 10, 15};

constexpr std::uint32_t kAnywhere = 0x1F;
constexpr std::uint32_t In(State state) { return 1U << static_cast<int>(state); }

struct Cause {
  wire::Fault fault;
  const char* text;
  std::uint32_t states;  // bits: where it can be seen
  void (*happen)(FirmwareBench&);
};

const Cause kCauses[] = {
    {wire::kFaultNotArmed, "commands without ARM", kAnywhere & ~In(State::kArmed),
     [](FirmwareBench& b) { b.SetAll(5); }},
    {wire::kFaultHostSilent, "commands end", In(State::kArmed), [](FirmwareBench& b) { b.host_speaks = false; }},
    {wire::kFaultOverTemperature, "board at 90 C", kAnywhere, [](FirmwareBench& b) { b.plant.faults.board_C = 90; }},
    {wire::kFaultOverTemperature, "all copper at 85 C at once", In(State::kArmed),
     [](FirmwareBench& b) { b.plant.SetTemperature(85); }},
    {wire::kFaultOverCurrent, "a sensor reads 16 A", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.current_reading_A = 16; }},
    {wire::kFaultDriver, "a bridge reports a fault", kAnywhere, [](FirmwareBench& b) { b.plant.faults.driver = true; }},
    {wire::kFaultSupplyLow, "8 V", kAnywhere & ~In(State::kBoot), [](FirmwareBench& b) { b.plant.SetSupply(8); }},
    {wire::kFaultSupplyHigh, "28 V", kAnywhere, [](FirmwareBench& b) { b.plant.SetSupply(28); }},
    {wire::kFaultPower, "voltages read 1.6 times too high", In(State::kArmed),
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
    {wire::kFaultFan, "the fan stops", kAnywhere, [](FirmwareBench& b) { b.plant.faults.fan_stands = true; }},
    {wire::kFaultEmergencyStop, "the switch opens", kAnywhere,
     [](FirmwareBench& b) { b.plant.faults.emergency_stop = true; }},
    {wire::kFaultEmergencyStop, "ESTOP", kAnywhere, [](FirmwareBench& b) { b.Send(wire::Estop{}); }},
    {wire::kFaultSelfTest, "a sensor shows no test field", In(State::kBoot),
     [](FirmwareBench& b) { b.plant.faults.test_field_dead = true; }},
    {wire::kFaultSelfTest, "a coil's voltage reads 1.25 times too high", In(State::kBoot) | In(State::kSelfTest),
     [](FirmwareBench& b) { b.plant.faults.voltage_reading = 1.25; }},
    {wire::kFaultWatchdog, "the firmware hangs", kAnywhere,
     [](FirmwareBench& b) { b.Reset(ResetCause::kWatchdog, kWatchdog_ms); }},
    {wire::kFaultInternal, "the clock stops", kAnywhere, [](FirmwareBench& b) { b.plant.faults.clock_stands = true; }},
    {wire::kFaultInternal, "bridges are driven by mistake", In(State::kBoot) | In(State::kIdle) | In(State::kFault),
     [](FirmwareBench& b) { CoreTamper::DriveOf(b.core).Wake(); }},
    {wire::kFaultInternal, "a reset breaks the fault record", kAnywhere,
     [](FirmwareBench& b) {
       b.record.check ^= 1;
       b.Reset(ResetCause::kSoftware);
     }},
};

// Brings a base into a state; the self-test at its coil 1, kFault by a fault other than `coming`.
void Bring(FirmwareBench& bench, const Situation& situation, wire::Fault coming) {
  if (situation.state == State::kBoot) return bench.RunMs(2);
  if (situation.state == State::kSelfTest) {
    while (bench.outputs.duty[1] == 0) bench.Step();
    return bench.RunMs(10);
  }
  bench.RunUntil(State::kIdle, 1000);
  bench.RunMs(500);  // the fan has reached its speed
  if (situation.state == State::kIdle) return;
  bench.Arm();
  bench.SetAll(situation.current_A);
  bench.RunMs(50);
  if (situation.state == State::kArmed) return;
  if (coming == wire::kFaultEmergencyStop) {
    bench.plant.SetSupply(8);
    bench.RunMs(50);
    bench.plant.SetSupply(18);
  } else {
    bench.Send(wire::Estop{});
  }
  bench.RunMs(100);
}

// So that the situation's currents are near the limit of total power.
Settings SettingsFor(const Situation& situation) {
  Settings settings;
  float power_W = 0;
  for (const CoilSettings& coil : settings.coils) {
    power_W += situation.current_A * situation.current_A * coil.resistance_20C_ohm;
  }
  if (power_W > 0) settings.power_max_W = Min(settings.power_max_W, kPowerShare * power_W);
  return settings;
}

MatrixCell Measure(const Cause& cause, const Situation& situation) {
  FirmwareBench bench(SettingsFor(situation));
  Bring(bench, situation, cause.fault);
  MatrixCell cell{.situation = situation, .happens = true};
  cause.happen(bench);
  double after_ms = 0;
  for (double ms = 0; ms < kWatch_ms && after_ms < kAfter_ms; ms += kStep_ms) {
    if (!cell.detected && (bench.core.faults() & cause.fault) != 0) {
      cell.detected = true;
      cell.detected_ms = ms;
    }
    if (bench.plant.largest_A() > kZero_A) cell.zero_ms = ms + kStep_ms;
    if (cell.detected) after_ms += kStep_ms;
    bench.Step();
  }
  cell.left_A = bench.plant.largest_A();
  const Outputs& out = bench.outputs;
  cell.resting = out.awake == 0 && out.duty[0] == 0 && out.duty[1] == 0 && out.duty[2] == 0;
  return cell;
}

}  // namespace

std::vector<MatrixRow> MeasureFaultMatrix() {
  std::vector<MatrixRow> rows;
  for (const Cause& cause : kCauses) {
    MatrixRow row;
    row.fault = cause.fault;
    row.cause = cause.text;
    for (const Situation& situation : kSituations) {
      const bool happens = (cause.states & In(situation.state)) != 0;
      row.cells.push_back(happens ? Measure(cause, situation) : MatrixCell{.situation = situation});
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<SilenceRow> MeasureSilence() {
  std::vector<SilenceRow> rows;
  for (const float current_A : kSilenceCurrents_A) {
    SilenceRow row;
    row.current_A = current_A;
    for (const double supply_V : kSupplies_V) {
      FirmwareBench bench({}, {.supply_V = supply_V});
      bench.RunToArmed();
      bench.SetAll(current_A);
      bench.RunMs(50);
      bench.host_speaks = false;  // the last one came in the step before
      double zero_ms = 0;
      for (double ms = 0; ms < kAfter_ms; ms += kStep_ms) {
        if (bench.plant.largest_A() > kZero_A) zero_ms = ms + kStep_ms;
        bench.Step();
      }
      row.zero_ms.push_back(zero_ms);
      row.left_A = std::max(row.left_A, bench.plant.largest_A());
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace omni::firmware
