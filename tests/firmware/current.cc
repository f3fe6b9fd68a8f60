// Currents at their limits, and as the host streams them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_current {

TEST(FirmwareCurrent, DeratesWithTemperatureWithoutTripping) {
  FirmwarePlant::Options options;
  options.start_C = 50;
  FirmwareBench bench({}, options);
  ASSERT_TRUE(bench.RunToArmed());
  bench.SetAll(15);
  double at_full_C = 0, hottest_C = 0;
  bench.each_step = [&] {
    const double T_C =
        std::max({bench.plant.temperature_C(0), bench.plant.temperature_C(1), bench.plant.temperature_C(2)});
    hottest_C = std::max(hottest_C, T_C);
    if (bench.plant.current_A(2) > 14.9) at_full_C = std::max(at_full_C, bench.plant.temperature_C(2));
  };
  bench.RunMs(60'000);
  EXPECT_EQ(bench.core.faults(), 0U);
  EXPECT_GT(at_full_C, 57);
  EXPECT_LT(at_full_C, 63);
  EXPECT_LT(hottest_C, 70);
  EXPECT_LT(bench.plant.largest_A(), 10);
  EXPECT_GT(bench.plant.largest_A(), 1);
}

TEST(FirmwareCurrent, LowSupplyLimitsCurrentWithoutWindUp) {
  FirmwarePlant::Options options;
  options.supply_V = 10.5;
  options.start_C = 55;
  FirmwareBench bench({}, options);
  ASSERT_TRUE(bench.RunToArmed());
  bench.set_point_A[2] = 15;
  bench.RunMs(100);
  const double possible_A = 10.5 / bench.plant.resistance_ohm(2);
  EXPECT_LT(possible_A, 14);
  EXPECT_GT(bench.plant.current_A(2), 0.95 * possible_A);
  EXPECT_EQ(bench.core.faults(), 0U);
  // And back without wind-up.
  bench.set_point_A[2] = 5;
  double lowest_A = 15;
  bench.each_step = [&] { lowest_A = std::min(lowest_A, bench.plant.current_A(2)); };
  bench.RunMs(30);
  EXPECT_GT(lowest_A, 5 * 0.97);
  EXPECT_NEAR(bench.plant.current_A(2), 5, 0.03);
}

// Near its upper limit no energy may return to the supply: coils that reverse brake first, and still reach the target.
TEST(FirmwareCurrent, LimitsEnergyReturnedToAHighSupply) {
  for (const double supply_V : {18.0, 25.2}) {
    FirmwarePlant::Options options;
    options.supply_V = supply_V;
    FirmwareBench bench({}, options);
    ASSERT_TRUE(bench.RunToArmed());
    bench.SetAll(12);
    bench.RunMs(20);
    double fed_J = 0;
    bench.each_step = [&] {
      for (int k = 0; k < wire::kCoils; ++k) {
        const double power_W = supply_V * bench.outputs.duty[k] / wire::kDutyFull * bench.plant.current_A(k);
        if (power_W < 0) fed_J -= power_W * 250e-6;
      }
    };
    bench.SetAll(-12);
    bench.RunMs(30);
    if (supply_V < 20) {
      EXPECT_GT(fed_J, 0.05);  // it reverses with all its voltage
    } else {
      EXPECT_LT(fed_J, 0.02);
    }
    EXPECT_NEAR(bench.plant.current_A(0), -12, 0.1);
    EXPECT_EQ(bench.core.faults(), 0U);
  }
}

TEST(FirmwareCurrent, TotalPowerLimitKeepsTheCurrentRatio) {
  Settings settings;
  settings.power_max_W = 150;
  FirmwareBench bench(settings);
  ASSERT_TRUE(bench.RunToArmed());
  bench.set_point_A[0] = 15;
  bench.set_point_A[1] = -10;
  bench.RunMs(100);
  double power_W = 0;
  for (int k = 0; k < 3; ++k)
    power_W += bench.plant.current_A(k) * bench.plant.current_A(k) * bench.plant.resistance_ohm(k);
  EXPECT_NEAR(power_W, 150, 2);
  EXPECT_NEAR(bench.plant.current_A(0) / bench.plant.current_A(1), -1.5, 0.01);  // in the same direction
  EXPECT_EQ(bench.core.faults(), 0U);
}

TEST(FirmwareCurrent, SlewRateIsLimited) {
  Settings settings;
  settings.slew_max_A_s = 1000;
  FirmwareBench bench(settings);
  ASSERT_TRUE(bench.RunToArmed());
  bench.RunMs(10);
  double before_A = 0, steepest_A_s = 0;
  bench.each_step = [&] {
    steepest_A_s = std::max(steepest_A_s, std::abs(bench.plant.current_A(0) - before_A) / 250e-6);
    before_A = bench.plant.current_A(0);
  };
  for (const float target_A : {10.0F, -10.0F, 0.0F}) {
    bench.set_point_A[0] = target_A;
    bench.RunMs(40);
  }
  EXPECT_LT(steepest_A_s, 1060);
  EXPECT_GT(steepest_A_s, 900);
}

// Three coils at once, as the host moves them: a sine of 200 Hz of set-points at 1 kHz.
TEST(FirmwareCurrent, FollowsStreamedSetPoints) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  double worst_A = 0;
  for (int ms = 0; ms < 200; ++ms) {
    for (int k = 0; k < 3; ++k) bench.set_point_A[k] = static_cast<float>(4 * std::sin(0.3 * ms + k));
    bench.SendCommand();
    bench.RunMs(1);
    if (ms < 20) continue;
    for (int k = 0; k < 3; ++k) {
      worst_A = std::max(worst_A, std::abs(bench.plant.current_A(k) - static_cast<double>(bench.set_point_A[k])));
    }
  }
  EXPECT_LT(worst_A, 0.15);
  EXPECT_EQ(bench.core.faults(), 0U);
}

// Means are measured; the ends of steps are computed from them by the model. While currents change by amperes in a step
// the means are wrong by half of that.
TEST(FirmwareCurrent, TelemetryReportsCurrentAtTheEndOfEachControlStep) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.RunMs(10);
  std::array<std::array<double, 3>, kStepsPerTick + 1> true_A{};  // at the ends of the last steps, oldest first
  double worst_A = 0, worst_of_means_A = 0;
  int compared = 0, telemetry_count = bench.telemetry_count;
  bench.each_step = [&] {
    std::rotate(true_A.begin(), true_A.begin() + 1, true_A.end());
    for (int k = 0; k < 3; ++k) true_A.back()[static_cast<std::size_t>(k)] = bench.plant.current_A(k);
    if (bench.telemetry_count != telemetry_count) {
      for (std::size_t step = 0; step < kStepsPerTick; ++step) {
        for (std::size_t k = 0; k < 3; ++k) {
          const double reported_A = bench.telemetry.current[step][k] * wire::kCurrentUnit_A;
          worst_A = std::max(worst_A, std::abs(reported_A - true_A[step + 1][k]));
          worst_of_means_A = std::max(worst_of_means_A, 0.5 * std::abs(true_A[step + 1][k] - true_A[step][k]));
        }
      }
      ++compared;
    }
    telemetry_count = bench.telemetry_count;
  };
  for (int ms = 0; ms < 100; ++ms) {
    for (int k = 0; k < 3; ++k) bench.set_point_A[k] = static_cast<float>(6 * std::sin(0.7 * ms + k));
    bench.SendCommand();
    bench.RunMs(1);
  }
  EXPECT_GE(compared, 99);
  EXPECT_GT(worst_of_means_A, 0.5);
  EXPECT_LT(worst_A, 0.1 * worst_of_means_A);
}

TEST(FirmwareCurrent, TelemetryReportsElectricalStateOfTheCoils) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.set_point_A[0] = 4;
  bench.set_point_A[1] = -6;
  bench.RunMs(30);
  EXPECT_NEAR(bench.telemetry.current[3][0] * wire::kCurrentUnit_A, 4, 0.02);
  EXPECT_NEAR(bench.telemetry.current[3][1] * wire::kCurrentUnit_A, -6, 0.02);
  EXPECT_NEAR(bench.telemetry.voltage[1] * wire::kSupplyUnit_V, 6 * bench.plant.resistance_ohm(1), 0.05);
  EXPECT_LT(bench.telemetry.duty[1], 0);
  EXPECT_NEAR(bench.telemetry.resistance[0] * 1e-4, bench.plant.resistance_ohm(0), 0.005);
  EXPECT_NEAR(bench.telemetry.temperature[0] * 0.01, bench.plant.temperature_C(0), 3);
}

}  // namespace test_firmware_current
}  // namespace omni::firmware
