// The magnetometer's driver against its register model: start, samples, brown-out, wrong chips, bad buses, self-test.
#include "firmware/drivers/lis3mdl.h"

#include <gtest/gtest.h>

#include "tests/support/chips/lis3mdl_model.h"

namespace omni::drivers {
namespace test_drivers_lis3mdl {

using support::FaultySpi;
using support::Lis3mdlModel;

struct Lis3mdlTest : testing::Test {
  Lis3mdlModel chip;
  FaultySpi bus{chip};
  Lis3mdl<FaultySpi> driver{bus};
  Lis3mdlSample sample;
};

TEST_F(Lis3mdlTest, StartsAtAKilohertzAndSixteenGauss) {
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  EXPECT_EQ(chip.reg(0x20), 0x02);
  EXPECT_EQ(chip.reg(0x21), 0x60);
  EXPECT_EQ(chip.reg(0x22), 0x00);
  EXPECT_EQ(chip.reg(0x23), 0x00);
  EXPECT_EQ(chip.reg(0x24), 0x40);
  const long before = chip.samples();
  chip.Wait(1e6);
  EXPECT_NEAR(static_cast<double>(chip.samples() - before), 1000, 1);
}

TEST_F(Lis3mdlTest, ReadsAllAxesInOneTransfer) {
  chip.set_field_G({1, -15.5, 0.25});
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  chip.Wait(1000);
  const long transfers = bus.transfers;
  const long bytes = bus.bytes;
  ASSERT_EQ(driver.Read(sample), ChipStatus::kOk);
  EXPECT_EQ(bus.transfers - transfers, 1);
  EXPECT_EQ(bus.bytes - bytes, 8);
  EXPECT_EQ(sample.field[0], 1711);
  EXPECT_EQ(sample.field[1], -26521);
  EXPECT_EQ(sample.field[2], 428);
  EXPECT_FALSE(sample.overrun);
}

// ST's chip goes on at OUT_X_L behind OUT_Z_H: what lies behind is not in the same burst.
TEST_F(Lis3mdlTest, BurstBehindTheOutputBeginsAgainAtItsFirstByte) {
  chip.set_field_G({1, 2, 3});
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  chip.Wait(1000);
  std::uint8_t out[9] = {0x80 | 0x40 | 0x28}, in[9] = {};
  bus.Transfer(out, in, sizeof out);
  EXPECT_EQ(in[7], in[1]);
  EXPECT_EQ(in[8], in[2]);
}

TEST_F(Lis3mdlTest, LookSaysWhetherThereIsANewSample) {
  chip.set_field_G({1, 1, 1});
  EXPECT_EQ(driver.CheckForSample(), ChipStatus::kNotStarted);
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  EXPECT_EQ(driver.CheckForSample(), ChipStatus::kNoNewSample);
  chip.Wait(1000);
  const long bytes = bus.bytes;
  EXPECT_EQ(driver.CheckForSample(), ChipStatus::kOk);
  EXPECT_EQ(driver.CheckForSample(), ChipStatus::kOk) << "looking takes nothing away";
  EXPECT_EQ(bus.bytes - bytes, 4);
  ASSERT_EQ(driver.Read(sample), ChipStatus::kOk);
  EXPECT_EQ(driver.CheckForSample(), ChipStatus::kNoNewSample);
}

TEST_F(Lis3mdlTest, DistinguishesNewOldAndLostSamples) {
  chip.set_field_G({1, 1, 1});
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  chip.Wait(1000);
  ASSERT_EQ(driver.Read(sample), ChipStatus::kOk);
  EXPECT_EQ(driver.Read(sample), ChipStatus::kNoNewSample);
  EXPECT_EQ(sample.field[0], 1711) << "the previous sample";
  chip.Wait(2500);
  ASSERT_EQ(driver.Read(sample), ChipStatus::kOk);
  EXPECT_TRUE(sample.overrun);
}

// Polled a thousand times a second, a chip that is 2 % slow is not always fresh, one that is 2 % fast overruns.
TEST_F(Lis3mdlTest, ChipClockErrorShowsAsStaleOrOverrunSamples) {
  for (const double rate : {0.98, 1.02}) {
    chip.set_clock_rate(rate);
    ASSERT_EQ(driver.Start(), ChipStatus::kOk);
    chip.set_field_G({1, 2, 3});
    int fresh = 0;
    int overruns = 0;
    for (int i = 0; i < 1000; ++i) {
      chip.Wait(1000 - 8 * Lis3mdlModel::kByte_us);
      const ChipStatus status = driver.Read(sample);
      ASSERT_TRUE(status == ChipStatus::kOk || status == ChipStatus::kNoNewSample);
      fresh += status == ChipStatus::kOk;
      overruns += status == ChipStatus::kOk && sample.overrun;
    }
    // A sample that arrives while the previous one is read may be reported again, and count as an overrun.
    EXPECT_GE(fresh, rate < 1 ? 978 : 998);
    EXPECT_GE(overruns, rate < 1 ? 0 : 18);
    EXPECT_LE(overruns, rate < 1 ? 22 : 42);
  }
}

// High and low bytes belong to one sample even if it changes while they are read.
TEST_F(Lis3mdlTest, SamplesAreNeverTorn) {
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  bool high = false;
  for (int i = 0; i < 5000; ++i) {
    high = !high;
    const double field_G = high ? 255.0 / 1711 : 256.0 / 1711;  // 00FFh and 0100h
    chip.set_field_G({field_G, field_G, field_G});
    chip.Wait(987.3);
    driver.Read(sample);
    for (const std::int16_t counts : sample.field) ASSERT_TRUE(counts == 255 || counts == 256 || i == 0) << counts;
  }
}

TEST_F(Lis3mdlTest, RejectsOtherChips) {
  chip.set_identity(0x3C);
  EXPECT_EQ(driver.Start(), ChipStatus::kWrongIdentity);
  EXPECT_EQ(driver.Read(sample), ChipStatus::kNotStarted);
  EXPECT_EQ(driver.Verify(), ChipStatus::kNotStarted);
  EXPECT_EQ(driver.SetSelfTest(true), ChipStatus::kNotStarted);
  EXPECT_EQ(driver.counters().wrong_identity, 1U);
  EXPECT_EQ(chip.reg(0x22), 0x03) << "untouched";
}

TEST_F(Lis3mdlTest, ReportsBusErrorsAndRecovers) {
  chip.set_field_G({1, 1, 1});
  const struct {
    FaultySpi::Fault fault;
    ChipStatus at_start, at_read;
  } kCases[] = {
      {FaultySpi::Fault::kTimeout, ChipStatus::kTimeout, ChipStatus::kTimeout},
      {FaultySpi::Fault::kStuckLow, ChipStatus::kNoAnswer, ChipStatus::kNoAnswer},
      {FaultySpi::Fault::kStuckHigh, ChipStatus::kNoAnswer, ChipStatus::kNoAnswer},
  };
  for (const auto& wrong : kCases) {
    bus.fault = wrong.fault;
    EXPECT_EQ(driver.Start(), wrong.at_start);
    bus.fault = FaultySpi::Fault::kNone;
    ASSERT_EQ(driver.Start(), ChipStatus::kOk);
    chip.Wait(1000);
    ASSERT_EQ(driver.Read(sample), ChipStatus::kOk);
    bus.fault = wrong.fault;
    sample.field[0] = 77;
    EXPECT_EQ(driver.Read(sample), wrong.at_read);
    EXPECT_EQ(sample.field[0], 77) << "unchanged without a sample";
    EXPECT_NE(driver.Verify(), ChipStatus::kOk);
    bus.fault = FaultySpi::Fault::kNone;
    ASSERT_EQ(driver.Start(), ChipStatus::kOk);
    chip.Wait(1000);
    EXPECT_EQ(driver.Read(sample), ChipStatus::kOk);
    EXPECT_EQ(sample.field[0], 1711);
  }
  EXPECT_EQ(driver.counters().bus_errors, 9U);
}

TEST_F(Lis3mdlTest, GarbledBytesReportWrongIdentity) {
  bus.fault = FaultySpi::Fault::kWrongBytes;
  EXPECT_EQ(driver.Start(), ChipStatus::kWrongIdentity);
}

TEST_F(Lis3mdlTest, ReportsNoNewSampleBeforeTheFirst) {
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  EXPECT_EQ(driver.Read(sample), ChipStatus::kNoNewSample);
  EXPECT_EQ(driver.counters().bus_errors, 0U);
  chip.Wait(1000);
  EXPECT_EQ(driver.Read(sample), ChipStatus::kOk);
}

TEST_F(Lis3mdlTest, VerifyReconfiguresAfterBrownOut) {
  chip.set_field_G({1, 1, 1});
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  chip.Wait(1000);
  ASSERT_EQ(driver.Read(sample), ChipStatus::kOk);
  EXPECT_EQ(driver.Verify(), ChipStatus::kOk);
  chip.PowerCycle();
  chip.Wait(5000);
  EXPECT_EQ(driver.Read(sample), ChipStatus::kNoAnswer) << "powered down, outputs at zero";
  EXPECT_EQ(driver.Verify(), ChipStatus::kChanged);
  EXPECT_EQ(driver.counters().changed, 1U);
  chip.Wait(1000);
  EXPECT_EQ(driver.Read(sample), ChipStatus::kOk);
  EXPECT_EQ(driver.Verify(), ChipStatus::kOk);
}

TEST_F(Lis3mdlTest, VerifyRestoresSelfTestModeAfterBrownOut) {
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  ASSERT_EQ(driver.SetSelfTest(true), ChipStatus::kOk);
  chip.PowerCycle();
  EXPECT_EQ(driver.Verify(), ChipStatus::kChanged);
  EXPECT_EQ(chip.reg(0x20), 0x03);
}

TEST_F(Lis3mdlTest, DetectsRegistersThatIgnoreWrites) {
  chip.set_read_only(true);
  EXPECT_EQ(driver.Start(), ChipStatus::kNotTaken);
  EXPECT_FALSE(driver.started());
}

TEST_F(Lis3mdlTest, StartFailsWhenTheResetNeverEnds) {
  chip.set_reset_time_us(1e9);
  EXPECT_EQ(driver.Start(), ChipStatus::kNotTaken);
  EXPECT_LE(bus.transfers, 2 + Lis3mdl<FaultySpi>::kResetReads);
}

TEST_F(Lis3mdlTest, SelfTestAnswerIsCheckedPerAxis) {
  const auto answer = [&] {
    std::int16_t without[3];
    std::int16_t with[3];
    chip.Wait(2000);
    driver.Read(sample);
    for (int i = 0; i < 3; ++i) without[i] = sample.field[i];
    EXPECT_EQ(driver.SetSelfTest(true), ChipStatus::kOk);
    chip.Wait(lis3mdl::kSelfTestSettle_us);
    driver.Read(sample);
    for (int i = 0; i < 3; ++i) with[i] = sample.field[i];
    EXPECT_EQ(driver.SetSelfTest(false), ChipStatus::kOk);
    EXPECT_EQ(chip.reg(0x20), 0x02);
    return Lis3mdl<FaultySpi>::SelfTestAnswerIsRight(without, with);
  };
  chip.set_field_G({0.3, -0.4, 5});
  ASSERT_EQ(driver.Start(), ChipStatus::kOk);
  EXPECT_TRUE(answer());
  chip.set_self_test_G({-2, 2, -0.5});
  EXPECT_TRUE(answer()) << "the sign is not specified";
  chip.set_self_test_G({0, 2, 0.5});
  EXPECT_FALSE(answer()) << "dead axis";
  chip.set_self_test_G({2, 3.5, 0.5});
  EXPECT_FALSE(answer()) << "too much";
  chip.set_self_test_G({2, 2, 2});
  EXPECT_FALSE(answer()) << "z answers like x";
}

}  // namespace test_drivers_lis3mdl
}  // namespace omni::drivers
