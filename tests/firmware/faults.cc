// The fault matrix, its page, and the way back from a fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "firmware/wire/names.h"
#include "service/device/commands.h"
#include "tests/firmware/pages/fault_matrix.h"
#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_faults {

using wire::ArmStep;
using wire::State;

const std::vector<MatrixRow>& Matrix() {
  static const std::vector<MatrixRow> kRows = MeasureFaultMatrix();
  return kRows;
}

const std::vector<SilenceRow>& Silence() {
  static const std::vector<SilenceRow> kRows = MeasureSilence();
  return kRows;
}

constexpr double kZeroAfter_ms = 20;

// Heating, the fan and the self-test have no reaction time of milliseconds.
bool TakesTime(const MatrixRow& row) {
  return row.fault == wire::kFaultFan || row.fault == wire::kFaultSelfTest || row.fault == wire::kFaultOverTemperature;
}
// Not armed: no fault for a self-test.
bool GoesOn(const MatrixRow& row, const MatrixCell& cell) {
  return row.fault == wire::kFaultNotArmed && cell.situation.state == State::kSelfTest;
}

TEST(FirmwareFaultMatrix, DetectsEveryFaultAndEndsAtRest) {
  for (const MatrixRow& row : Matrix()) {
    for (const MatrixCell& cell : row.cells) {
      if (!cell.happens) continue;
      SCOPED_TRACE(testing::Message() << wire::FaultName(row.fault) << ": " << row.cause << ", in "
                                      << cell.situation.name);
      EXPECT_TRUE(cell.detected);
      EXPECT_TRUE(cell.resting);
      EXPECT_LT(cell.left_A, 0.01);
      if (GoesOn(row, cell)) continue;
      // Ramp 5 ms; brake: 15 A (a short: more) decay to 50 mA with the winding's L/R.
      EXPECT_LE(cell.zero_ms, cell.detected_ms + 12);
      EXPECT_TRUE(TakesTime(row) || cell.zero_ms < kZeroAfter_ms) << cell.zero_ms;
      EXPECT_LE(cell.detected_ms, TakesTime(row) || cell.situation.state == State::kBoot ? 3100 : kZeroAfter_ms);
    }
  }
}

TEST(FirmwareFaultMatrix, CoversEveryFault) {
  std::uint32_t seen = 0;
  for (const MatrixRow& row : Matrix()) seen |= row.fault;
  EXPECT_EQ(seen, (1U << kFaultCount) - 1);
}

// From the last COMMAND on, whatever flows and whatever supplies it.
TEST(FirmwareFaultMatrix, HostSilenceRemovesAllCurrentWithin20Ms) {
  const std::vector<SilenceRow>& rows = Silence();
  ASSERT_GE(rows.size(), 4U);
  EXPECT_EQ(rows.back().current_A, Settings{}.current_max_A);
  for (const SilenceRow& row : rows) {
    for (const double zero_ms : row.zero_ms) {
      EXPECT_LT(zero_ms, kZeroAfter_ms) << row.current_A << " A";
      EXPECT_GE(zero_ms, device::kCommandTimeToLive_ms) << row.current_A << " A: there was no current to remove";
    }
    EXPECT_LT(row.left_A, 0.001);
  }
}

TEST(FirmwareFaultMatrix, FaultsPageMatchesMeasurements) {
  std::ifstream file(OMNI_SOURCE_DIR "/docs/protocol/faults.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), FaultPage(Matrix(), Silence())) << "build the target fault_matrix and put its output there";
}

TEST(FirmwareFaults, HostSilenceRampsBrakesAndReturnsToIdle) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.SetAll(10);
  bench.RunMs(30);
  bench.host_speaks = false;
  bench.RunMs(device::kCommandTimeToLive_ms - 1);
  EXPECT_GT(bench.plant.largest_A(), 9.9);
  bench.RunMs(7);
  EXPECT_LT(bench.plant.largest_A(), 0.3);
  EXPECT_EQ(bench.outputs.duty[0], 0);
  EXPECT_EQ(bench.outputs.awake, 7);  // brakes
  bench.RunMs(15);
  EXPECT_EQ(bench.outputs.awake, 0);
  EXPECT_EQ(bench.core.state(), State::kIdle);
  EXPECT_EQ(bench.core.faults(), wire::kFaultNotArmed | wire::kFaultHostSilent);
  EXPECT_EQ(bench.Arm().step, ArmStep::kRefused);  // still silent
  bench.host_speaks = true;
  bench.SetAll(0);
  bench.RunMs(2);
  EXPECT_EQ(bench.Arm().step, ArmStep::kArmed);
  EXPECT_EQ(bench.core.faults(), 0U);
}

// A late host: a gap of eleven milliseconds has no effect, one of thirteen disarms; repeatedly.
TEST(FirmwareFaults, CommandGapWithinTimeToLiveDoesNotDisarm) {
  for (const int late_ms : {11, 13}) {
    FirmwareBench bench;
    ASSERT_TRUE(bench.RunToArmed());
    bench.SetAll(10);
    bench.RunMs(30);
    double least_A = 10;
    bench.each_step = [&] { least_A = std::min(least_A, bench.plant.largest_A()); };
    for (int i = 0; i < 20; ++i) {
      bench.host_speaks = false;
      bench.RunMs(late_ms);
      bench.host_speaks = true;
      bench.SendCommand();
    }
    const bool is_late = late_ms > device::kCommandTimeToLive_ms;
    EXPECT_EQ(bench.core.state(), is_late ? State::kIdle : State::kArmed) << late_ms;
    EXPECT_EQ(least_A > 9.9, !is_late) << late_ms << " ms: " << least_A << " A";
  }
}

TEST(FirmwareFaults, HonoursTheTimeToLiveOfEachCommand) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.host_speaks = false;
  wire::Command command = bench.CommandNow();
  command.time_to_live_ms = 5;
  bench.Send(command);
  bench.RunMs(5);
  EXPECT_EQ(bench.core.state(), State::kArmed);
  bench.RunMs(0.5);
  EXPECT_EQ(bench.core.state(), State::kIdle);
}

TEST(FirmwareFaults, StayUntilArmFindsTheCauseGone) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.plant.faults.emergency_stop = true;
  bench.RunMs(50);
  EXPECT_EQ(bench.core.state(), State::kFault);
  wire::Arm answer = bench.Arm();
  EXPECT_EQ(answer.step, ArmStep::kRefused);
  EXPECT_EQ(answer.faults, wire::kFaultEmergencyStop);
  bench.plant.faults.emergency_stop = false;
  bench.RunMs(1000);
  EXPECT_EQ(bench.core.state(), State::kFault);
  EXPECT_EQ(bench.Arm().step, ArmStep::kArmed);
}

TEST(FirmwareFaults, BrakeOverridesRamp) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.SetAll(10);
  bench.RunMs(20);
  bench.plant.faults.hall_dead = true;  // ramps
  while ((bench.core.faults() & wire::kFaultHallSensor) == 0) bench.Step();
  EXPECT_NE(bench.outputs.duty[0], 0);
  bench.Send(wire::Estop{});
  bench.Step();
  for (const std::int16_t duty : bench.outputs.duty) EXPECT_EQ(duty, 0);
  EXPECT_EQ(bench.outputs.awake, 7);
}

TEST(FirmwareFaults, SingleHallJumpIsDiscardedWithoutFault) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.RunMs(10);
  const std::int16_t before = bench.telemetry.field[3][0];
  bench.plant.faults.hall_jump = true;
  bench.RunMs(1);
  bench.plant.faults.hall_jump = false;
  EXPECT_NEAR(bench.telemetry.field[3][0], before, 100);
  bench.RunMs(50);
  EXPECT_EQ(bench.core.faults(), 0U);
  EXPECT_NEAR(bench.telemetry.field[3][0], before, 100);
}

TEST(FirmwareFaults, RecordSurvivesReset) {
  FaultRecord kept;
  {
    FirmwareBench bench;
    ASSERT_TRUE(bench.RunToArmed());
    bench.plant.faults.driver = true;
    bench.RunMs(10);
    wire::FaultEvent event;
    ASSERT_TRUE(bench.Take(event));
    EXPECT_EQ(event.fault, wire::kFaultDriver);
    EXPECT_EQ(event.state, State::kArmed);
    EXPECT_EQ(event.part, 1);
    EXPECT_EQ(event.after_reset, 0);
    kept = bench.record;
  }
  FirmwareBench bench({}, {}, ResetCause::kSoftware, kept);
  EXPECT_EQ(bench.core.faults(), wire::kFaultNotArmed);
  Bytes ask(wire::kFrameSizeMax);
  wire::Header header;
  header.type = wire::MessageType::kFault;
  ask.resize(wire::SealFrame(header, 0, ask.data(), ask.size()).size);
  bench.Receive(ask);
  bench.Fetch();
  wire::FaultEvent event;
  ASSERT_TRUE(bench.Take(event));
  EXPECT_EQ(event.fault, wire::kFaultDriver);
  EXPECT_EQ(event.after_reset, 1);
  EXPECT_EQ(event.state, State::kArmed);
}

TEST(FirmwareFaults, CorruptRecordIsAFaultExceptAfterPowerOn) {
  FaultRecord noise;
  noise.fault = 0x12345678;
  noise.check = 0xDEADBEEF;
  FaultRecord again = noise;
  Core after_power(Settings{}, ResetCause::kPower, 1, noise);
  EXPECT_EQ(after_power.faults(), wire::kFaultNotArmed);
  EXPECT_EQ(noise.fault, 0U);
  EXPECT_EQ(noise.check, CheckOf(noise));
  Core after_reset(Settings{}, ResetCause::kSoftware, 1, again);
  EXPECT_EQ(after_reset.faults(), wire::kFaultNotArmed | wire::kFaultInternal);
}

TEST(FirmwareFaults, StoppedClockStopsFeedingTheWatchdog) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.RunMs(10);
  EXPECT_EQ(bench.outputs.feed_watchdog, 1);
  bench.plant.faults.clock_stands = true;
  bench.Step();
  EXPECT_EQ(bench.outputs.feed_watchdog, 0);
}

}  // namespace test_firmware_faults
}  // namespace omni::firmware
