// The current monitor's driver against its register model: start, scales, alert, bad buses.
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

  // As the board does, in a transfer of its own.
  std::uint16_t ReadRegister(std::uint8_t number) {
    std::uint8_t in[2] = {};
    EXPECT_EQ(bus.Transfer(0x40, &number, 1, in, sizeof in), BusStatus::kOk);
    return static_cast<std::uint16_t>((in[0] << 8) | in[1]);
  }

  Ina260Model chip;
  FaultyI2c bus;
  Ina260<FaultyI2c> driver{bus, 0x40};
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
    const auto current = static_cast<std::int16_t>(ReadRegister(ina260::kCurrent));
    const std::uint16_t voltage = ReadRegister(ina260::kVoltage);
    EXPECT_NEAR(current * static_cast<double>(ina260::kCurrentUnit_A), current_A, 0.000626);
    EXPECT_NEAR(voltage * static_cast<double>(ina260::kVoltageUnit_V), 11.5, 0.000626);
  }
}

TEST_F(Ina260Test, ReadingBackOmitsTheRegisterPointer) {
  ASSERT_EQ(Start(), ChipStatus::kOk);
  // Five writes, five reads, one of them of what was written last.
  EXPECT_EQ(bus.bytes, 5 * 4 + 4 * 5 + 3);
  // After an error the pointer is unknown.
  bus.fault_in = 4;
  bus.fault_then = FaultyI2c::Fault::kNack;
  EXPECT_EQ(Start(), ChipStatus::kNack);
  bus.fault = FaultyI2c::Fault::kNone;
  bus.fault_in = -1;
  const long before = bus.bytes;
  ASSERT_EQ(Start(), ChipStatus::kOk);
  EXPECT_EQ(bus.bytes - before, 5 * 4 + 4 * 5 + 3);
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
  EXPECT_NE(ReadRegister(ina260::kMaskEnable) & ina260::kAlertFlag, 0);
  EXPECT_FALSE(chip.alert_is_low());
  EXPECT_EQ(ReadRegister(ina260::kMaskEnable) & ina260::kAlertFlag, 0);
}

// The chip's comparison is signed: set for positive currents it does not detect -40 A.
TEST_F(Ina260Test, AlertActsOnPositiveCurrents) {
  ASSERT_EQ(Start(), ChipStatus::kOk);
  chip.set_current_A(-40);
  bus.Wait(300);
  EXPECT_FALSE(chip.alert_is_low());
}

TEST_F(Ina260Test, BusErrorAnywhereRequiresRestart) {
  for (int after = 0; after < 10; ++after) {
    bus.fault_in = after;
    bus.fault_then = FaultyI2c::Fault::kStuck;
    EXPECT_EQ(Start(), ChipStatus::kTimeout) << after;
    EXPECT_FALSE(driver.started()) << after;
    bus.fault = FaultyI2c::Fault::kNone;
    bus.fault_in = -1;
    ASSERT_EQ(Start(), ChipStatus::kOk) << after;
    EXPECT_EQ(chip.reg(0x06), 0x8001);
    EXPECT_EQ(chip.reg(0x07), 12400);
  }
}

TEST_F(Ina260Test, RejectsOtherChipsButAcceptsOtherRevisions) {
  chip.set_identity(0x5449, 0x2260);  // an INA226
  EXPECT_EQ(Start(), ChipStatus::kWrongIdentity);
  chip.set_identity(0x5448, 0x2270);
  EXPECT_EQ(Start(), ChipStatus::kWrongIdentity);
  EXPECT_FALSE(driver.started());
  EXPECT_EQ(chip.reg(0x00), 0x6127) << "untouched";
  chip.set_identity(0x5449, 0x2271);
  EXPECT_EQ(Start(), ChipStatus::kOk);
}

TEST_F(Ina260Test, ReportsBusErrorsAndRecovers) {
  Ina260<FaultyI2c> nobody(bus, 0x41);
  EXPECT_EQ(nobody.Start(ina260::Mode::kCurrentOnly, kLimit), ChipStatus::kNack);
  bus.fault = FaultyI2c::Fault::kNack;
  EXPECT_EQ(Start(), ChipStatus::kNack);
  bus.fault = FaultyI2c::Fault::kStuck;
  EXPECT_EQ(Start(), ChipStatus::kTimeout);
  bus.fault = FaultyI2c::Fault::kWrongBytes;
  EXPECT_EQ(Start(), ChipStatus::kWrongIdentity);
  EXPECT_FALSE(driver.started());
  bus.fault = FaultyI2c::Fault::kNone;
  EXPECT_EQ(Start(), ChipStatus::kOk);
}

TEST_F(Ina260Test, DetectsRegistersThatIgnoreWrites) {
  chip.set_read_only(true);
  EXPECT_EQ(Start(), ChipStatus::kNotTaken);
  EXPECT_FALSE(driver.started());
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
  EXPECT_EQ(chip.reg(0x01), 800);
  EXPECT_EQ(others[0].reg(0x01), 1600);
  EXPECT_EQ(others[1].reg(0x01), static_cast<std::uint16_t>(-2400));
}

}  // namespace test_drivers_ina260
}  // namespace omni::drivers
