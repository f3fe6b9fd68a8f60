// While a fault's cause persists, ARM is refused and names it: for every detector, at every moment.
#include <gtest/gtest.h>

#include "firmware/wire/names.h"
#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_arm {

using wire::ArmStep;
using wire::State;

struct StandingFault {
  const char* name;
  wire::Fault fault;
  void (*begin)(FirmwareBench&);
  // For faults that cannot be detected at rest: the current at the time. ARM is refused by the self-test it requires.
  float current_A = 0;
};

void PrintTo(const StandingFault& standing, std::ostream* out) { *out << standing.name; }

const StandingFault kStanding[] = {
    {"hostSilent", wire::kFaultHostSilent, [](FirmwareBench& b) { b.host_speaks = false; }, 1},
    {"boardTooHot", wire::kFaultOverTemperature, [](FirmwareBench& b) { b.plant.faults.board_C = 90; }},
    {"copperTooHot", wire::kFaultOverTemperature, [](FirmwareBench& b) { b.plant.SetTemperature(85); }, 15},
    {"overCurrent", wire::kFaultOverCurrent, [](FirmwareBench& b) { b.plant.faults.current_reading_A = 16; }},
    {"driver", wire::kFaultDriver, [](FirmwareBench& b) { b.plant.faults.driver = true; }},
    {"supplyLow", wire::kFaultSupplyLow, [](FirmwareBench& b) { b.plant.SetSupply(8); }},
    {"supplyHigh", wire::kFaultSupplyHigh, [](FirmwareBench& b) { b.plant.SetSupply(28); }},
    {"power", wire::kFaultPower, [](FirmwareBench& b) { b.plant.faults.voltage_reading = 1.6; }, 15},
    {"coilOpen", wire::kFaultCoilOpen, [](FirmwareBench& b) { b.plant.faults.coil_open = true; }, 5},
    {"coilShort", wire::kFaultCoilShort, [](FirmwareBench& b) { b.plant.faults.coil_short = true; }, 5},
    {"offItsModel", wire::kFaultModel, [](FirmwareBench& b) { b.plant.SetTemperature(-60); }, 2},
    {"currentSensor", wire::kFaultCurrentSensor, [](FirmwareBench& b) { b.plant.faults.current_sensor_dead = true; }},
    {"hallDead", wire::kFaultHallSensor, [](FirmwareBench& b) { b.plant.faults.hall_dead = true; }},
    {"hallStuck", wire::kFaultHallStuck, [](FirmwareBench& b) { b.plant.faults.hall_stuck = true; }},
    {"hallJump", wire::kFaultHallJump, [](FirmwareBench& b) { b.plant.faults.hall_flutters = true; }},
    {"fan", wire::kFaultFan, [](FirmwareBench& b) { b.plant.faults.fan_stands = true; }},
    {"emergencyStop", wire::kFaultEmergencyStop, [](FirmwareBench& b) { b.plant.faults.emergency_stop = true; }},
    {"clockStands", wire::kFaultInternal, [](FirmwareBench& b) { b.plant.faults.clock_stands = true; }},
};

// Faults whose cause cannot persist: "not armed" is not a failure, a self-test runs again, a watchdog reset is over.
constexpr std::uint32_t kNothingStands = wire::kFaultNotArmed | wire::kFaultSelfTest | wire::kFaultWatchdog;

TEST(FirmwareArm, TableCoversEveryFault) {
  std::uint32_t seen = kNothingStands;
  for (const StandingFault& standing : kStanding) seen |= standing.fault;
  EXPECT_EQ(seen, (1U << kFaultCount) - 1);
}

class FirmwareArm : public testing::TestWithParam<StandingFault> {};

TEST_P(FirmwareArm, IsRefusedWhileTheCausePersists) {
  const StandingFault& standing = GetParam();
  Settings settings;
  if (standing.fault == wire::kFaultPower) settings.power_max_W = 500;
  FirmwareBench bench(settings);
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  bench.RunMs(500);
  if (standing.current_A > 0) {
    ASSERT_EQ(bench.Arm().step, ArmStep::kArmed);
    bench.SetAll(standing.current_A);
    bench.RunMs(50);
  }
  standing.begin(bench);
  for (int ms = 0; ms < 4000 && (bench.core.faults() & standing.fault) == 0; ++ms) bench.RunMs(1);
  ASSERT_NE(bench.core.faults() & standing.fault, 0U) << "it was never detected";
  int armed = 0, named = 0, asked = 0;
  for (int i = 0; i < 200; ++i) {
    bench.RunMs(50);
    for (int step = i % kStepsPerTick; step > 0; --step) bench.Step();  // at every step of a tick
    ++asked;
    const wire::Arm answer = bench.Arm();
    armed += answer.step == ArmStep::kArmed ? 1 : 0;
    named += answer.step == ArmStep::kRefused && answer.faults != 0 ? 1 : 0;
  }
  EXPECT_EQ(armed, 0) << "times of " << asked << " in 10 s";
  EXPECT_EQ(named, asked);
}

INSTANTIATE_TEST_SUITE_P(All, FirmwareArm, testing::ValuesIn(kStanding),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace test_firmware_arm
}  // namespace omni::firmware
