// The current monitor's driver against its register model: start, scales, alert and its side, brown-out, bad buses.
#include "firmware/drivers/ina260.h"

#include <gtest/gtest.h>

#include "tests/support/chips/ina260_model.h"

namespace omni::drivers {
namespace test_drivers_ina260 {

using support::FaultyI2c;
using support::Ina260Model;

constexpr std::int16_t kLimit = ina260::CurrentCounts(15.5F);

struct Ina260Test : testing::Test {
  Ina260Test() { bus.Attach(0x40, chip); }

  ChipStatus Start() { return driver.Start(ina260::Mode::kCurrentAndVoltage, kLimit); }

  Ina260Model chip;
  FaultyI2c bus;
  Ina260<FaultyI2c> driver{bus, 0x40};
  std::int16_t current = 0;
  std::uint16_t voltage = 0;
  bool struck = false;
};

TEST_F(Ina260Test, StartsWithTheShortestConversionsAndALatchedAlert) {
  EXPECT_EQ(kLimit, 12400);
  ASSERT_EQ(Start(), ChipStatus::kOk);
  EXPECT_EQ(chip.reg(0x00), 0x6007);
  EXPECT_EQ(chip.reg(0x06), 0x8001);
  EXPECT_EQ(chip.reg(0x07), 12400);
  const long before = chip.conversions();
  bus.Wait(14000);
  EXPECT_EQ(chip.conversions() - before, 100);
}

TEST_F(Ina260Test, ReadsSignedCurrentAndVoltage) {
  ASSERT_EQ(Start(), ChipStatus::kOk);
  for (const double current_A : {0.0, 5.0, -15.0, 0.00125, -40.96}) {
    chip.set_current_A(current_A);
    chip.set_voltage_V(11.5);
    bus.Wait(300);
    ASSERT_EQ(driver.ReadCurrent(current), ChipStatus::kOk);
    ASSERT_EQ(driver.ReadVoltage(voltage), ChipStatus::kOk);
    EXPECT_NEAR(current * static_cast<double>(ina260::kCurrentUnit_A), current_A, 0.000626);
    EXPECT_NEAR(voltage * static_cast<double>(ina260::kVoltageUnit_V), 11.5, 0.000626);
  }
}

TEST_F(Ina260Test, RepeatedReadsOmitTheRegisterPointer) {
  ASSERT_EQ(Start(), ChipStatus::kOk);
  const auto cost = [&](auto&& read) {
    const long before = bus.bytes;
    EXPECT_EQ(read(), ChipStatus::kOk);
    return bus.bytes - before;
  };
  const auto read_current = [&] { return driver.ReadCurrent(current); };
  const auto read_voltage = [&] { return driver.ReadVoltage(voltage); };
  EXPECT_EQ(cost(read_current), 5);
  EXPECT_EQ(cost(read_current), 3);
  EXPECT_EQ(cost(read_voltage), 5);
  EXPECT_EQ(cost(read_current), 5);
  // After an error the pointer is unknown.
  bus.fault = FaultyI2c::Fault::kNack;
  EXPECT_EQ(driver.ReadCurrent(current), ChipStatus::kNack);
  bus.fault = FaultyI2c::Fault::kNone;
  EXPECT_EQ(cost(read_current), 5);
}

TEST_F(Ina260Test, OverCurrentAlertIsLatchedUntilRead) {
  ASSERT_EQ(Start(), ChipStatus::kOk);
  chip.set_current_A(15.4);
  bus.Wait(300);
  EXPECT_FALSE(chip.alert_is_low());
  chip.set_current_A(15.6);
  bus.Wait(300);
  EXPECT_TRUE(chip.alert_is_low());
  chip.set_current_A(0);
  bus.Wait(3000);
  EXPECT_TRUE(chip.alert_is_low()) << "latched";
  EXPECT_EQ(driver.Verify(), ChipStatus::kOk);
  EXPECT_TRUE(chip.alert_is_low()) << "verifying does not release it";
  ASSERT_EQ(driver.ReadAlert(struck), ChipStatus::kOk);
  EXPECT_TRUE(struck);
  EXPECT_FALSE(chip.alert_is_low());
  ASSERT_EQ(driver.ReadAlert(struck), ChipStatus::kOk);
  EXPECT_FALSE(struck);
}

// The chip's comparison is signed: set for positive currents it does not detect -40 A.
TEST_F(Ina260Test, AlertActsOnTheSelectedSide) {
  ASSERT_EQ(Start(), ChipStatus::kOk);
  chip.set_current_A(-40);
  bus.Wait(300);
  EXPECT_FALSE(chip.alert_is_low());
  chip.set_current_A(-1);
  bus.Wait(300);
  ASSERT_EQ(driver.SetAlertSide(AlertSide::kNegative), ChipStatus::kOk);
  bus.Wait(1000);
  EXPECT_FALSE(chip.alert_is_low());
  EXPECT_EQ(driver.Verify(), ChipStatus::kOk);
  chip.set_current_A(-15.6);
  bus.Wait(300);
  EXPECT_TRUE(chip.alert_is_low());
  chip.set_current_A(1);
  bus.Wait(300);
  ASSERT_EQ(driver.ReadAlert(struck), ChipStatus::kOk);
  EXPECT_TRUE(struck);
  ASSERT_EQ(driver.SetAlertSide(AlertSide::kPositive), ChipStatus::kOk);
  bus.Wait(1000);
  EXPECT_FALSE(chip.alert_is_low());
  const long bytes = bus.bytes;
  ASSERT_EQ(driver.SetAlertSide(AlertSide::kPositive), ChipStatus::kOk);
  EXPECT_EQ(bus.bytes, bytes) << "the same side costs nothing";
}

TEST_F(Ina260Test, BusErrorWhileChangingAlertSideRequiresRestart) {
  for (int after = 0; after < 3; ++after) {
    ASSERT_EQ(Start(), ChipStatus::kOk);
    bus.fault_in = after;
    bus.fault_then = FaultyI2c::Fault::kStuck;
    EXPECT_EQ(driver.SetAlertSide(AlertSide::kNegative), ChipStatus::kTimeout);
    EXPECT_EQ(driver.ReadCurrent(current), ChipStatus::kNotStarted);
    bus.fault = FaultyI2c::Fault::kNone;
    bus.fault_in = -1;
    ASSERT_EQ(Start(), ChipStatus::kOk);
    EXPECT_EQ(chip.reg(0x06), 0x8001);
    EXPECT_EQ(chip.reg(0x07), 12400);
  }
}

TEST_F(Ina260Test, RejectsOtherChipsButAcceptsOtherRevisions) {
  chip.set_identity(0x5449, 0x2260);  // an INA226
  EXPECT_EQ(Start(), ChipStatus::kWrongIdentity);
  chip.set_identity(0x5448, 0x2270);
  EXPECT_EQ(Start(), ChipStatus::kWrongIdentity);
  EXPECT_EQ(driver.counters().wrong_identity, 2U);
  EXPECT_EQ(driver.ReadCurrent(current), ChipStatus::kNotStarted);
  EXPECT_EQ(driver.ReadAlert(struck), ChipStatus::kNotStarted);
  EXPECT_EQ(driver.Verify(), ChipStatus::kNotStarted);
  EXPECT_EQ(driver.SetAlertSide(AlertSide::kNegative), ChipStatus::kNotStarted);
  EXPECT_EQ(chip.reg(0x00), 0x6127) << "untouched";
  chip.set_identity(0x5449, 0x2271);
  EXPECT_EQ(Start(), ChipStatus::kOk);
}

TEST_F(Ina260Test, ReportsBusErrorsAndRecovers) {
  Ina260<FaultyI2c> nobody(bus, 0x41);
  EXPECT_EQ(nobody.Start(ina260::Mode::kCurrentOnly, kLimit), ChipStatus::kNack);
  ASSERT_EQ(Start(), ChipStatus::kOk);
  current = 77;
  bus.fault = FaultyI2c::Fault::kNack;
  EXPECT_EQ(driver.ReadCurrent(current), ChipStatus::kNack);
  bus.fault = FaultyI2c::Fault::kStuck;
  EXPECT_EQ(driver.ReadCurrent(current), ChipStatus::kTimeout);
  EXPECT_EQ(driver.ReadVoltage(voltage), ChipStatus::kTimeout);
  EXPECT_EQ(driver.Verify(), ChipStatus::kTimeout);
  EXPECT_EQ(driver.ReadAlert(struck), ChipStatus::kTimeout);
  EXPECT_EQ(current, 77) << "unchanged without a measurement";
  EXPECT_EQ(driver.counters().bus_errors, 5U);
  bus.fault = FaultyI2c::Fault::kWrongBytes;
  EXPECT_EQ(Start(), ChipStatus::kWrongIdentity);
  bus.fault = FaultyI2c::Fault::kNone;
  EXPECT_EQ(Start(), ChipStatus::kOk);
}

TEST_F(Ina260Test, VerifyReconfiguresAfterBrownOut) {
  ASSERT_EQ(Start(), ChipStatus::kOk);
  ASSERT_EQ(driver.SetAlertSide(AlertSide::kNegative), ChipStatus::kOk);
  chip.PowerCycle();
  EXPECT_EQ(driver.ReadAlert(struck), ChipStatus::kNotTaken);
  EXPECT_EQ(driver.Verify(), ChipStatus::kChanged);
  EXPECT_EQ(chip.reg(0x00), 0x6007);
  EXPECT_EQ(chip.reg(0x06), 0x4001);
  EXPECT_EQ(chip.reg(0x07), static_cast<std::uint16_t>(-12400));
  EXPECT_EQ(driver.Verify(), ChipStatus::kOk);
}

TEST_F(Ina260Test, DetectsRegistersThatIgnoreWrites) {
  chip.set_read_only(true);
  EXPECT_EQ(Start(), ChipStatus::kNotTaken);
  EXPECT_EQ(driver.counters().changed, 1U);
}

TEST_F(Ina260Test, ThreeChipsShareABus) {
  Ina260Model others[2];
  bus.Attach(0x41, others[0]);
  bus.Attach(0x44, others[1]);
  Ina260<FaultyI2c> second(bus, 0x41);
  Ina260<FaultyI2c> third(bus, 0x44);
  ASSERT_EQ(Start(), ChipStatus::kOk);
  ASSERT_EQ(second.Start(ina260::Mode::kCurrentOnly, kLimit), ChipStatus::kOk);
  ASSERT_EQ(third.Start(ina260::Mode::kCurrentOnly, kLimit), ChipStatus::kOk);
  chip.set_current_A(1);
  others[0].set_current_A(2);
  others[1].set_current_A(-3);
  bus.Wait(300);
  std::int16_t counts[3] = {};
  EXPECT_EQ(driver.ReadCurrent(counts[0]), ChipStatus::kOk);
  EXPECT_EQ(second.ReadCurrent(counts[1]), ChipStatus::kOk);
  EXPECT_EQ(third.ReadCurrent(counts[2]), ChipStatus::kOk);
  EXPECT_EQ(counts[0], 800);
  EXPECT_EQ(counts[1], 1600);
  EXPECT_EQ(counts[2], -2400);
}

}  // namespace test_drivers_ina260
}  // namespace omni::drivers
