// The H bridge's driver against its pins: the order of direction, brake and sleep under any sequence of calls.
#include "firmware/drivers/g2_driver.h"

#include <gtest/gtest.h>

#include <random>

namespace omni::drivers {
namespace test_drivers_g2 {

// The pins, with checks of what must never happen to them.
struct Pins {
  void SetDuty(std::uint16_t new_duty) noexcept {
    EXPECT_LE(new_duty, 32767);
    EXPECT_TRUE(awake || new_duty == 0) << "drives while asleep";
    if (duty != 0 && new_duty == 0) braked_since = period;
    duty = new_duty;
  }
  void SetDirection(bool new_negative) noexcept {
    if (new_negative != negative && awake) {
      EXPECT_EQ(duty, 0) << "changes direction while driving";
      EXPECT_GE(period - braked_since, 2U) << "less than one whole period of brake";
    }
    negative = new_negative;
  }
  void SetAwake(bool new_awake) noexcept {
    if (awake && !new_awake) {
      EXPECT_EQ(duty, 0);
      EXPECT_GE(period - braked_since, 200U) << "asleep before the current is gone";
    }
    if (!awake && new_awake) braked_since = period;
    awake = new_awake;
  }
  bool FaultIsLow() const noexcept { return fault; }
  std::uint32_t PwmPeriods() const noexcept { return period; }

  int signed_duty() const { return negative ? -duty : duty; }

  std::uint32_t period = 0xFFFFFF00U;  // wraps soon
  std::uint32_t braked_since = 0xFFFFFF00U;
  std::uint16_t duty = 0;
  bool negative = false, awake = false, fault = false;
};

struct G2Test : testing::Test {
  // Control steps of 250 us, five periods each.
  void Run(int steps, std::int16_t duty, bool awake) {
    for (int i = 0; i < steps; ++i) {
      driver.Apply(duty, awake);
      pins.period += 5;
    }
  }

  Pins pins;
  G2Driver<Pins> driver{pins};
};

TEST_F(G2Test, WakesBrakedThenDrivesInBothDirections) {
  driver.Start();
  EXPECT_FALSE(pins.awake);
  Run(1, 1000, true);
  EXPECT_TRUE(pins.awake);
  EXPECT_EQ(pins.duty, 0) << "first awake, braking";
  Run(1, 1000, true);
  EXPECT_EQ(pins.signed_duty(), 1000);
  Run(1, 32767, true);
  EXPECT_EQ(pins.signed_duty(), 32767) << "the same sign at once";
  Run(1, -32767, true);
  EXPECT_EQ(pins.duty, 0) << "brake between the signs";
  Run(1, -32767, true);
  EXPECT_EQ(pins.signed_duty(), -32767);
}

TEST_F(G2Test, BrakesForAWholePeriodBeforeReversing) {
  driver.Start();
  Run(4, 500, true);
  ASSERT_EQ(pins.signed_duty(), 500);
  driver.Apply(-500, true);
  pins.period += 1;
  driver.Advance();
  EXPECT_EQ(pins.duty, 0) << "that period had begun before";
  pins.period += 1;
  driver.Advance();
  EXPECT_EQ(pins.signed_duty(), -500);
}

TEST_F(G2Test, BrakesTenMillisecondsBeforeSleeping) {
  driver.Start();
  Run(10, 20000, true);
  Run(40, 20000, false);
  EXPECT_EQ(pins.duty, 0);
  EXPECT_TRUE(pins.awake);
  Run(1, 20000, false);
  EXPECT_FALSE(pins.awake);
  EXPECT_FALSE(driver.awake());
}

TEST_F(G2Test, BrakesWhenApplyIsNotCalled) {
  driver.Start();
  Run(10, 20000, true);
  pins.period += 35;
  driver.Advance();
  EXPECT_EQ(pins.signed_duty(), 20000);
  pins.period += 2;
  driver.Advance();
  EXPECT_EQ(pins.duty, 0);
  EXPECT_TRUE(pins.awake) << "brake, not coast";
  EXPECT_EQ(driver.counters().dead, 1U);
  driver.Advance();
  EXPECT_EQ(driver.counters().dead, 1U);
  Run(2, 20000, true);
  EXPECT_EQ(pins.signed_duty(), 20000) << "drives again";
}

TEST_F(G2Test, RejectsDutyBeyondFullScale) {
  driver.Start();
  Run(5, 100, true);
  Run(1, -32768, true);
  EXPECT_EQ(pins.duty, 0);
  EXPECT_EQ(driver.counters().rejected, 1U);
}

TEST_F(G2Test, FaultBrakesWhileAwake) {
  driver.Start();
  pins.fault = true;
  Run(2, 100, true);
  EXPECT_FALSE(driver.fault()) << "not valid just after waking";
  pins.fault = false;
  Run(10, 100, true);
  ASSERT_EQ(pins.signed_duty(), 100);
  pins.fault = true;
  Run(3, 100, true);
  EXPECT_TRUE(driver.fault());
  EXPECT_EQ(pins.duty, 0);
  EXPECT_EQ(driver.counters().faults, 1U);
  pins.fault = false;
  Run(2, 100, true);
  EXPECT_FALSE(driver.fault());
  EXPECT_EQ(pins.signed_duty(), 100);
  Run(60, 0, false);
  pins.fault = true;
  Run(3, 0, false);
  EXPECT_FALSE(driver.fault()) << "not valid while asleep";
}

// Pins checks the rules; this makes random calls.
TEST_F(G2Test, RandomCallsNeverViolateThePinRules) {
  std::mt19937 random(11);
  driver.Start();
  long driven = 0;
  long slept = 0;
  for (int i = 0; i < 300000; ++i) {
    if (random() % 4 != 0) {
      const int duty = static_cast<int>(random() % 65536) - 32768;
      driver.Apply(static_cast<std::int16_t>(random() % 3 == 0 ? 0 : duty), (i / 500) % 3 != 0);
    } else {
      driver.Advance();
    }
    if (random() % 100 == 0) pins.fault = !pins.fault;
    pins.period += static_cast<std::uint32_t>(random() % 50 == 0 ? random() % 100 : random() % 4);
    driven += pins.duty != 0;
    slept += !pins.awake;
  }
  EXPECT_GT(driven, 10000);
  EXPECT_GT(slept, 10000);
  EXPECT_GT(driver.counters().dead, 100U);
}

}  // namespace test_drivers_g2
}  // namespace omni::drivers
