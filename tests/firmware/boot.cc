// From power-on to armed, and what prevents it.
#include <gtest/gtest.h>

#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_boot {

using wire::ArmStep;
using wire::State;

TEST(FirmwareBoot, RunsSelfTestThenIdlesAndArms) {
  FirmwareBench bench;
  EXPECT_EQ(bench.core.state(), State::kBoot);
  ASSERT_TRUE(bench.RunUntil(State::kSelfTest, 100));
  bool saw_test_field = false;
  double largest_A = 0;
  bench.each_step = [&] {
    saw_test_field = saw_test_field || bench.outputs.hall_self_test != 0;
    largest_A = std::max(largest_A, bench.plant.largest_A());
  };
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  EXPECT_TRUE(saw_test_field);
  EXPECT_GT(largest_A, 0.8);
  EXPECT_LT(largest_A, 1.2);
  EXPECT_EQ(bench.outputs.awake, 0);
  EXPECT_EQ(bench.core.faults(), wire::kFaultNotArmed);
  EXPECT_EQ(bench.Arm().step, ArmStep::kArmed);
  EXPECT_EQ(bench.core.state(), State::kArmed);
  EXPECT_EQ(bench.core.faults(), 0U);
  bench.RunMs(1);
  EXPECT_EQ(bench.telemetry.state, State::kArmed);
  EXPECT_EQ(bench.bad_frames, 0);
}

TEST(FirmwareBoot, SendsTelemetryEveryMillisecondFromBoot) {
  FirmwareBench bench;
  bench.RunMs(100);
  EXPECT_EQ(bench.telemetry_count, 100);
  EXPECT_EQ(bench.telemetry.missed_ticks, 0);
}

TEST(FirmwareBoot, SelfTestResistancesSetInitialTemperatures) {
  FirmwarePlant::Options options;
  options.start_C = 55;
  FirmwareBench bench({}, options);
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  for (int k = 0; k < wire::kCoils; ++k) EXPECT_NEAR(bench.core.heat().temperature_C(k), 55, 3) << k;
  EXPECT_NEAR(bench.core.heat().body_C(), 55, 3);
}

struct Refusal {
  const char* name;
  void (*break_it)(FirmwareBench&);
  std::uint32_t faults;
};

class FirmwareSelfTest : public testing::TestWithParam<Refusal> {};

TEST_P(FirmwareSelfTest, FailsWithTheMatchingFaultUntilTheCauseIsGone) {
  FirmwareBench bench;
  GetParam().break_it(bench);
  ASSERT_TRUE(bench.RunUntil(State::kFault, 2000));
  EXPECT_EQ(bench.core.faults() & GetParam().faults, GetParam().faults) << std::hex << bench.core.faults();
  bench.RunMs(50);
  EXPECT_EQ(bench.outputs.awake, 0);
  EXPECT_LT(bench.plant.largest_A(), 0.01);
  // ARM starts it again, and with the cause gone it passes.
  bench.plant.faults = {};
  bench.plant.SetSupply(18);
  bench.RunMs(20);
  const wire::Arm answer = bench.Arm();
  EXPECT_EQ(answer.step, ArmStep::kRefused);
  EXPECT_EQ(answer.faults, wire::kFaultSelfTest);
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 2000));
  EXPECT_EQ(bench.Arm().step, ArmStep::kArmed);
}

INSTANTIATE_TEST_SUITE_P(
    All, FirmwareSelfTest,
    testing::Values(
        Refusal{"deadHall", [](FirmwareBench& b) { b.plant.faults.hall_dead = true; },
                wire::kFaultHallSensor | wire::kFaultSelfTest},
        Refusal{"deadTestField", [](FirmwareBench& b) { b.plant.faults.test_field_dead = true; },
                wire::kFaultHallSensor | wire::kFaultSelfTest},
        Refusal{"reversedTestField", [](FirmwareBench& b) { b.plant.faults.test_field_reversed = true; },
                wire::kFaultHallSensor | wire::kFaultSelfTest},
        Refusal{"deadCurrentSensor", [](FirmwareBench& b) { b.plant.faults.current_sensor_dead = true; },
                wire::kFaultCurrentSensor | wire::kFaultSelfTest},
        Refusal{"reversedCurrent", [](FirmwareBench& b) { b.plant.faults.current_reversed = true; },
                wire::kFaultModel | wire::kFaultSelfTest},
        Refusal{"wrongResistance", [](FirmwareBench& b) { b.plant.faults.voltage_reading = 1.25; },
                wire::kFaultSelfTest},
        Refusal{"openCoil", [](FirmwareBench& b) { b.plant.faults.coil_open = true; }, wire::kFaultCoilOpen},
        Refusal{"shortCoil", [](FirmwareBench& b) { b.plant.faults.coil_short = true; }, wire::kFaultCoilShort},
        Refusal{"noSupply", [](FirmwareBench& b) { b.plant.SetSupply(0); }, wire::kFaultSupplyLow}),
    [](const auto& test) { return test.param.name; });

TEST(FirmwareBoot, TestsSensorsEvenWithoutSupply) {
  FirmwareBench bench;
  bench.plant.SetSupply(0);
  bool saw_test_field = false;
  bench.each_step = [&] { saw_test_field = saw_test_field || bench.outputs.hall_self_test != 0; };
  ASSERT_TRUE(bench.RunUntil(State::kFault, 1000));
  EXPECT_TRUE(saw_test_field);
  EXPECT_EQ(bench.core.faults(), wire::kFaultSupplyLow | wire::kFaultNotArmed);
}

TEST(FirmwareBoot, ReportsWatchdogResetUntilArm) {
  FaultRecord record;
  record.check = CheckOf(record);
  FirmwareBench bench({}, {}, ResetCause::kWatchdog, record);
  ASSERT_TRUE(bench.RunUntil(State::kFault, 1000));
  EXPECT_EQ(bench.core.faults(), wire::kFaultWatchdog | wire::kFaultNotArmed);
  EXPECT_EQ(bench.Arm().step, ArmStep::kArmed);
}

TEST(FirmwareBoot, NanSettingsNeverArm) {
  Settings settings;
  settings.coils[1].resistance_20C_ohm = std::numeric_limits<float>::quiet_NaN();
  FaultRecord record;
  Core core(settings, ResetCause::kPower, 1, record);
  EXPECT_EQ(core.faults() & wire::kFaultInternal, wire::kFaultInternal);
  FirmwareBench bench(Settings{});
  FirmwareBench broken(settings);
  EXPECT_FALSE(broken.RunUntil(State::kIdle, 1000));
  const wire::Arm answer = broken.Arm();
  EXPECT_EQ(answer.step, ArmStep::kRefused);
  EXPECT_EQ(answer.faults & wire::kFaultInternal, wire::kFaultInternal);
}

TEST(FirmwareArming, NonceIsValidOnceAndFor100ms) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  wire::Arm confirm;
  confirm.step = ArmStep::kConfirm;
  bench.Send(confirm);  // without a request
  bench.Send(wire::Arm{});
  bench.Fetch();
  wire::Arm challenge;
  ASSERT_TRUE(bench.Take(challenge));
  ASSERT_EQ(challenge.step, ArmStep::kChallenge);

  confirm.nonce = challenge.nonce ^ 1;
  bench.Send(confirm);  // wrong, which also invalidates the right one
  confirm.nonce = challenge.nonce;
  bench.Send(confirm);
  EXPECT_EQ(bench.core.state(), State::kIdle);

  bench.answers.clear();
  bench.Send(wire::Arm{});
  bench.Fetch();
  ASSERT_TRUE(bench.Take(challenge));
  bench.RunMs(101);
  confirm.nonce = challenge.nonce;
  bench.Send(confirm);
  EXPECT_EQ(bench.core.state(), State::kIdle);

  EXPECT_EQ(bench.Arm().step, ArmStep::kArmed);
}

TEST(FirmwareArming, RefusesOtherProtocolVersions) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  wire::Arm asked;
  asked.version = wire::kVersion + 1;
  bench.Send(asked);
  bench.Fetch();
  wire::Arm answer;
  ASSERT_TRUE(bench.Take(answer));
  EXPECT_EQ(answer.step, ArmStep::kRefused);

  wire::Hello hello;  // a host that only speaks newer versions
  hello.version_min = wire::kVersion + 1;
  hello.version_max = wire::kVersion + 2;
  hello.field_lsb_T = hello.current_max_A = 1;
  hello.field_full_scale = 1;
  bench.Send(hello);
  bench.Fetch();
  wire::Log log;
  ASSERT_TRUE(bench.Take(log));
  EXPECT_EQ(std::string(log.text, log.size), "refuses to arm: the host speaks protocol 2 to 3, this base 1");
  EXPECT_EQ(bench.Arm().step, ArmStep::kRefused);
  hello.version_min = wire::kVersion;
  bench.Send(hello);
  EXPECT_EQ(bench.Arm().step, ArmStep::kArmed);
}

TEST(FirmwareArming, SetPointsFromBeforeArmingDoNotAct) {
  FirmwareBench bench;
  bench.SetAll(10);
  ASSERT_TRUE(bench.RunToArmed());
  bench.host_speaks = false;
  bench.RunMs(15);
  EXPECT_LT(bench.plant.largest_A(), 0.01);
}

}  // namespace test_firmware_boot
}  // namespace omni::firmware
