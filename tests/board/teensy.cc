// The Teensy's board code on a model of its chip: what reaches the pins and what is reported to the control core.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "firmware/board/teensy40/board.h"
#include "firmware/board/teensy40/chip/chip.h"
#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/core/run.h"
#include "tests/support/chips/teensy_chip.h"

namespace omni::board {
namespace test_board_teensy {

using support::TeensyChip;

constexpr int kStep_us = static_cast<int>(firmware::kStepPeriod_us);

// The board as main brings it up, stepped by the test instead of an interrupt.
class TeensyBoard : public ::testing::Test {
 protected:
  void Start() {
    OpenClockGates();
    SetUpPins();
    SetUpClocks();
    board_ = std::make_unique<Board>(settings_);
    board_->Start();
    begin_us_ = chip_.now_us;
  }

  // One control step; what the buses' interrupts do comes between the steps.
  const firmware::Inputs& Step(const firmware::Outputs& outputs) {
    inputs_ = firmware::Inputs();
    board_->Read(inputs_);
    board_->Write(outputs);
    Interrupts();
    chip_.Wait(begin_us_ + kStep_us - chip_.now_us);
    begin_us_ += kStep_us;
    return inputs_;
  }
  const firmware::Inputs& Steps(int count, const firmware::Outputs& outputs) {
    for (int i = 0; i < count; ++i) Step(outputs);
    return inputs_;
  }
  void Interrupts() {
    for (int i = 0; i < 100 && chip_.I2cInterruptPending(); ++i) board_->CurrentBusInterrupt();
  }

  void SetUp() override {
    for (auto& current : chip_.currents) current.set_voltage_V(12);
  }

  TeensyChip chip_;
  firmware::Settings settings_;
  std::unique_ptr<Board> board_;
  firmware::Inputs inputs_;
  double begin_us_ = 0;
};

firmware::Outputs Driving(std::int16_t duty) {
  firmware::Outputs outputs;
  for (std::int16_t& each : outputs.duty) each = duty;
  outputs.awake = 7;
  return outputs;
}

TEST(TeensyPwm, DutyMapsToPwmTicks) {
  EXPECT_EQ(kPwmTicks, 7500) << "150 MHz / 20 kHz";
  EXPECT_EQ(PwmHighTicks(0), 0);
  EXPECT_EQ(PwmHighTicks(kDutyFull), kPwmTicks);
  EXPECT_EQ(PwmHighTicks(60000), kPwmTicks);
  for (int duty = 1; duty < kDutyFull; ++duty) {
    const double exact = static_cast<double>(duty) * kPwmTicks / kDutyFull;
    ASSERT_NEAR(PwmHighTicks(static_cast<std::uint16_t>(duty)), exact, 0.5) << duty;
  }
}

TEST_F(TeensyBoard, SetUpPinsAppliesThePinTableWithOutputsAtRest) {
  SetUpPins();
  for (const Pin& pin : kPins) {
    const std::uint32_t mux = kIomuxBase + static_cast<std::uint32_t>(pin.pad);
    EXPECT_EQ(chip_.Held(mux), pin.function) << static_cast<int>(pin.signal);
    EXPECT_EQ(chip_.Held(mux + kPadControlOffset), pin.control) << static_cast<int>(pin.signal);
    if (!pin.output) continue;
    EXPECT_EQ(chip_.Pin(pin.port, pin.bit), pin.signal == Signal::kHallSelectOff) << static_cast<int>(pin.signal);
  }
}

TEST_F(TeensyBoard, StartsWithBridgesAsleepAndBraking) {
  Start();
  for (int k = 0; k < kBridges; ++k) EXPECT_EQ(chip_.HighTicks(k), 0);
  for (const Signal awake : {Signal::kBridgeAwake0, Signal::kBridgeAwake1, Signal::kBridgeAwake2}) {
    EXPECT_FALSE(chip_.Pin(PinOf(awake).port, PinOf(awake).bit));
  }
  // 600 MHz: 24 MHz * 100 / 2 / 2, buses a quarter [RM CCM].
  EXPECT_EQ(chip_.Held(0x400D8000) & 0x7F, 100U);
  EXPECT_EQ(chip_.Held(0x400FC010), 1U);
  EXPECT_EQ(chip_.Held(0x400FC014) >> 8 & 3, 3U);
  EXPECT_EQ(chip_.Held(0x400FC014) >> 25 & 1, 0U);
  EXPECT_EQ(chip_.spi_unselected, 0);
}

TEST_F(TeensyBoard, ReportsChipReadingsToTheCore) {
  for (int i = 0; i < 8; ++i) chip_.halls[i].set_field_G({0.1 * (i + 1), -1, 2});
  for (int k = 0; k < 3; ++k) chip_.currents[k].set_current_A(2.0 - 2 * k);
  Start();
  const firmware::Inputs& in = Steps(40, {});
  EXPECT_EQ(in.field_answers, 0xFF);
  EXPECT_EQ(in.current_answers, 7);
  for (int i = 0; i < 8; ++i) {
    EXPECT_NEAR(in.field[i][0], 171.1 * (i + 1), 1) << i;
    EXPECT_NEAR(in.field[i][2], 3422, 1) << i;
    // All eight convert at once here: a millisecond, two steps until a chip is looked at, four until the last one is
    // read.
    EXPECT_LT(in.field_age_us[i], 1000 + 500 + 1000) << i;
  }
  EXPECT_EQ(in.current[0], 1600);
  EXPECT_EQ(in.current[1], 0);
  EXPECT_EQ(in.current[2], -1600);
  EXPECT_EQ(in.supply, 9600);
  EXPECT_EQ(in.driver_fault, 0);
  EXPECT_EQ(in.emergency_stop, 0);
  // 85 C - (1300 - 1200) (85 - 25) / (1500 - 1200)
  EXPECT_EQ(in.board_temperature, 6500);
  EXPECT_EQ(chip_.i2c_without_master_code, 0);
  EXPECT_EQ(chip_.i2c_overfilled, 0);
  EXPECT_EQ(chip_.spi_unselected, 0);
}

TEST_F(TeensyBoard, MarksEachHallSampleFreshOnce) {
  Start();
  Steps(8, {});
  int fresh[8] = {};
  for (int step = 0; step < 400; ++step) {
    Step({});
    for (int i = 0; i < 8; ++i) fresh[i] += inputs_.field_fresh >> i & 1;
  }
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(fresh[i], 100, 8) << "100 ms at 1 kHz, its own clock: " << i;
}

// Two thirds of a step remain for core, currents and USB.
TEST_F(TeensyBoard, HallBusIsShortInEveryStep) {
  Start();
  for (int step = 0; step < 400; ++step) {
    const double before_us = chip_.spi_us;
    Step({});
    EXPECT_LE(chip_.spi_us - before_us, 100) << step;
  }
}

// Chips that are gone or frozen take no time from the others.
TEST_F(TeensyBoard, OtherHallSamplesComeInTimeBesideDeadAndFrozenChips) {
  chip_.hall_there[1] = chip_.hall_there[6] = false;
  Start();
  Steps(8, {});
  chip_.halls[4].Freeze();
  int fresh[8] = {};
  for (int step = 0; step < 400; ++step) {
    Step({});
    for (int i = 0; i < 8; ++i) fresh[i] += inputs_.field_fresh >> i & 1;
  }
  for (const int i : {0, 2, 3, 5, 7}) EXPECT_NEAR(fresh[i], 100, 8) << i;
}

TEST_F(TeensyBoard, FrozenHallChipIsResetOnce) {
  Start();
  Steps(40, {});
  chip_.halls[2].Freeze();
  int fresh = 0;
  for (int step = 0; step < 2000; ++step) {
    Step({});
    board_->Maintain();
    if (step > 1200) fresh += inputs_.field_fresh >> 2 & 1;
  }
  EXPECT_NEAR(fresh, 200, 10) << "it converts again after its reset";
  // One that stays frozen is left alone after that: resets would take the bus from the others.
  chip_.halls[2].set_frozen_for_good();
  for (int step = 0; step < 4000; ++step) {
    Step({});
    board_->Maintain();
  }
  EXPECT_EQ(chip_.halls[2].resets(), 3) << "at the start, and once for each time it froze";
}

TEST_F(TeensyBoard, DrivesAfterWakingAndBrakesBeforeSleep) {
  Start();
  Steps(2, Driving(16384));
  EXPECT_TRUE(chip_.Pin(1, 18)) << "awake";
  Steps(2, Driving(16384));
  for (int k = 0; k < kBridges; ++k) EXPECT_EQ(chip_.HighTicks(k), PwmHighTicks(16384));
  EXPECT_EQ(Step(Driving(16384)).voltage[0], 9600U * 16384 / 32767);
  // The other direction: a step of brake between.
  Step(Driving(-16384));
  EXPECT_EQ(chip_.HighTicks(0), 0);
  EXPECT_FALSE(chip_.Pin(2, 17)) << "direction";
  Step(Driving(-16384));
  EXPECT_EQ(chip_.HighTicks(0), PwmHighTicks(16384));
  EXPECT_TRUE(chip_.Pin(2, 17));
  int steps = 0;
  for (; steps < 100 && chip_.Pin(1, 18); ++steps) {
    Step({});
    EXPECT_EQ(chip_.HighTicks(0), 0);
  }
  EXPECT_NEAR(steps * kStep_us, 10'000, 2 * kStep_us) << "brake before sleep";
}

TEST_F(TeensyBoard, FaultLineBrakesAllBridgesInHardwareAndIsReported) {
  Start();
  Steps(30, Driving(16384));
  chip_.coil_line_low[1] = true;
  for (int k = 0; k < kBridges; ++k) EXPECT_EQ(chip_.HighTicks(k), 0) << "no step has run: " << k;
  // A short pulse is reported too, and holds until nothing is driven.
  chip_.Wait(0);
  chip_.coil_line_low[1] = false;
  EXPECT_EQ(chip_.HighTicks(0), 0);
  Steps(2, Driving(16384));
  EXPECT_EQ(inputs_.driver_fault, 2);
  EXPECT_EQ(chip_.HighTicks(0), 0);
  Steps(2, {});
  EXPECT_EQ(Step({}).driver_fault, 0) << "cleared once the core has stopped driving";
}

TEST_F(TeensyBoard, EmergencyStopBrakesInHardwareAndIsReported) {
  Start();
  EXPECT_EQ(Steps(30, Driving(8000)).emergency_stop, 0);
  chip_.switch_open = true;
  EXPECT_EQ(chip_.HighTicks(2), 0);
  EXPECT_EQ(Step(Driving(8000)).emergency_stop, 1);
  EXPECT_EQ(Steps(100, {}).emergency_stop, 1) << "as long as it is open";
  chip_.switch_open = false;
  EXPECT_EQ(Steps(3, {}).emergency_stop, 0);
}

TEST_F(TeensyBoard, ReportsMissingChipsAndStartsThemLater) {
  chip_.hall_there[3] = false;
  chip_.current_there[1] = false;
  Start();
  Steps(40, {});
  EXPECT_EQ(inputs_.field_answers, 0xF7);
  EXPECT_EQ(inputs_.current_answers, 5);
  chip_.hall_there[3] = chip_.current_there[1] = true;
  for (int step = 0; step < 2000 && (inputs_.field_answers != 0xFF || inputs_.current_answers != 7); ++step) {
    Step({});
    board_->Maintain();
  }
  EXPECT_EQ(inputs_.field_answers, 0xFF);
  EXPECT_EQ(inputs_.current_answers, 7);
}

TEST_F(TeensyBoard, DeadCurrentSensorDoesNotAffectTheOthers) {
  Start();
  Steps(10, {});
  for (int dead = 0; dead < 4; ++dead) {
    chip_.current_there[dead] = false;
    Steps(8, {});
    EXPECT_EQ(inputs_.current_answers, dead < 3 ? 7 & ~(1 << dead) : 7) << dead;
    EXPECT_EQ(inputs_.supply, dead < 3 ? 9600 : 0) << dead;
    chip_.current_there[dead] = true;
    Steps(2, {});
    EXPECT_EQ(inputs_.current_answers, 7) << dead;
  }
  EXPECT_EQ(chip_.i2c_overfilled, 0);
}

TEST_F(TeensyBoard, RecoversAfterAHeldI2cLineIsReleased) {
  Start();
  Steps(10, {});
  chip_.i2c_line_held = true;
  EXPECT_EQ(Steps(10, {}).current_answers, 0);
  EXPECT_EQ(inputs_.field_answers, 0xFF);
  chip_.i2c_line_held = false;
  EXPECT_EQ(Steps(4, {}).current_answers, 7);
}

TEST_F(TeensyBoard, AlertFollowsTheSignOfTheCurrent) {
  Start();
  chip_.currents[0].set_current_A(-3);
  Steps(40, Driving(-8000));
  EXPECT_EQ(chip_.currents[0].reg(0x06) & 0xFC01, 0x4001) << "under limit, latched";
  EXPECT_EQ(static_cast<std::int16_t>(chip_.currents[0].reg(0x07)), -12400) << "-15.5 A";
  EXPECT_EQ(chip_.currents[1].reg(0x06) & 0xFC01, 0x8001);
  chip_.currents[0].set_current_A(-16);
  Steps(4, Driving(-8000));
  EXPECT_TRUE(chip_.currents[0].alert_is_low());
  // Its line is low now; once nothing is driven the latch is read, which ends it.
  chip_.currents[0].set_current_A(0);
  chip_.coil_line_low[0] = true;
  Steps(10, {});
  EXPECT_FALSE(chip_.currents[0].alert_is_low());
}

TEST_F(TeensyBoard, PowerCycledCurrentSensorIsInvalidUntilReconfigured) {
  Start();
  Steps(10, {});
  chip_.currents[2].PowerCycle();
  bool doubted = false;
  for (int step = 0; step < 600; ++step) {
    Step({});
    doubted = doubted || inputs_.current_answers == 3;
  }
  EXPECT_TRUE(doubted);
  for (int step = 0; step < 200; ++step) {
    Step({});
    board_->Maintain();
  }
  EXPECT_EQ(inputs_.current_answers, 7);
  EXPECT_EQ(chip_.currents[2].reg(0x06) & 0x8001, 0x8001);
}

TEST_F(TeensyBoard, HallSelfTestReachesAllChipsWithinEightSteps) {
  Start();
  Steps(8, {});
  firmware::Outputs test;
  test.hall_self_test = 1;
  Steps(8, test);
  for (const auto& hall : chip_.halls) EXPECT_EQ(hall.reg(0x20) & 1, 1);
  Steps(8, {});
  for (const auto& hall : chip_.halls) EXPECT_EQ(hall.reg(0x20) & 1, 0);
}

TEST_F(TeensyBoard, TimeIsContinuousAcrossCounterWrap) {
  Start();
  Steps(30, Driving(8000));
  const double wrap_us = 4294967296.0;
  chip_.now_us = begin_us_ = wrap_us - 10.0 * kStep_us;
  std::uint64_t before = Step(Driving(8000)).now_us;
  for (int step = 0; step < 20; ++step) {
    const std::uint64_t now = Step(Driving(8000)).now_us;
    EXPECT_EQ(now - before, firmware::kStepPeriod_us);
    before = now;
  }
  EXPECT_GT(before, 4294967296U);
  EXPECT_EQ(chip_.HighTicks(0), PwmHighTicks(8000)) << "and the bridges are unaffected";
}

TEST_F(TeensyBoard, FeedsWatchdogOnlyWhenTheCoreRequestsIt) {
  Start();
  StartWatchdog();
  EXPECT_EQ(chip_.Held(0x400BC008), 262U) << "8 ms of 32.768 kHz";
  const long before = chip_.watchdog_feeds;
  Steps(10, {});
  EXPECT_EQ(chip_.watchdog_feeds, before);
  firmware::Outputs well;
  well.feed_watchdog = 1;
  Steps(10, well);
  EXPECT_EQ(chip_.watchdog_feeds, before + 10);
}

// The core itself on this board, with coils, a fan and the noise of real sensors: it must find everything in order.
TEST_F(TeensyBoard, CorePassesSelfTestOnThisBoard) {
  constexpr double kSupply_V = 12, kStep_s = kStep_us * 1e-6, kNoise_G = 0.01;
  constexpr int kFanEdgeSteps = 40;  // 3000 turns a minute, two edges each
  double current_A[3] = {};
  double largest_A = 0;
  Start();
  firmware::FaultRecord record;
  firmware::Runner<Board> runner(*board_, settings_, firmware::ResetCause::kPower, 1, record);
  const long before = chip_.watchdog_feeds;
  int step = 0;
  for (; step < 8000 && runner.core().state() != wire::State::kIdle; ++step) {
    runner.Step();
    board_->Maintain();
    for (int k = 0; k < 3; ++k) {
      const Pin& direction = PinOf(static_cast<Signal>(static_cast<int>(Signal::kBridgeDirection0) + k));
      const double sign = chip_.Pin(direction.port, direction.bit) ? -1 : 1;
      const double voltage_V = sign * kSupply_V * chip_.HighTicks(k) / kPwmTicks;
      const auto r_ohm = static_cast<double>(settings_.coils[k].resistance_20C_ohm);
      const double decay = std::exp(-kStep_s * r_ohm / static_cast<double>(settings_.coils[k].inductance_H));
      current_A[k] = voltage_V / r_ohm + (current_A[k] - voltage_V / r_ohm) * decay;
      largest_A = std::max(largest_A, std::abs(current_A[k]));
      chip_.currents[k].set_current_A(current_A[k]);
    }
    for (int i = 0; i < 8; ++i)
      chip_.halls[i].set_field_G({kNoise_G * (step % 7 + i), kNoise_G * (step % 5), kNoise_G * (step % 3)});
    if (step % kFanEdgeSteps == 0) chip_.FanEdge();
    Interrupts();
    chip_.Wait(begin_us_ + kStep_us - chip_.now_us);
    begin_us_ += kStep_us;
  }
  EXPECT_EQ(runner.core().state(), wire::State::kIdle) << std::hex << runner.core().faults();
  EXPECT_EQ(runner.core().faults(), wire::kFaultNotArmed) << std::hex << runner.core().faults();
  EXPECT_EQ(chip_.watchdog_feeds, before + step);
  EXPECT_NEAR(largest_A, 1, 0.3) << "the self-test's current";
  for (int k = 0; k < kBridges; ++k) EXPECT_EQ(chip_.HighTicks(k), 0);
}

// Without supply nothing is driven, but the core runs, reports faults and feeds the watchdog: no endless resets.
TEST_F(TeensyBoard, BareBoardReportsFaultsAndKeepsFeedingTheWatchdog) {
  for (bool& there : chip_.hall_there) there = false;
  for (bool& there : chip_.current_there) there = false;
  Start();
  firmware::FaultRecord record;
  firmware::Runner<Board> runner(*board_, settings_, firmware::ResetCause::kPower, 1, record);
  const long before = chip_.watchdog_feeds;
  for (int step = 0; step < 4000; ++step) {
    runner.Step();
    Interrupts();
    board_->Maintain();
    chip_.Wait(begin_us_ + kStep_us - chip_.now_us);
    begin_us_ += kStep_us;
    for (int k = 0; k < kBridges; ++k) ASSERT_EQ(chip_.HighTicks(k), 0);
  }
  EXPECT_EQ(chip_.watchdog_feeds, before + 4000);
  EXPECT_EQ(runner.core().state(), wire::State::kFault);
  EXPECT_NE(runner.core().faults() & (wire::kFaultHallSensor | wire::kFaultCurrentSensor | wire::kFaultSelfTest), 0U);
}

}  // namespace test_board_teensy
}  // namespace omni::board
