// Currents: how fast, how exact, and what they do where they cannot do what is asked.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/support/firmware_bench.h"

namespace omni::firmware {
namespace {

struct Response {
  double rise_ms = 0;  // 10 to 90 %
  double overshoot = 0;
  double steady_error = 0;  // mean over 20 ms, 30 ms after the step
};

// One step of one coil, of the true current.
Response StepResponse(FirmwareBench& bench, int coil, float target_A) {
  double at_10_ms = -1, at_90_ms = -1, largest_A = 0, sum_A = 0, t_ms = 0;
  int count = 0;
  bench.each_step = [&] {
    const double current_A = bench.plant.current_A(coil);
    t_ms += 0.25;
    largest_A = std::max(largest_A, current_A);
    if (at_10_ms < 0 && current_A >= 0.1 * static_cast<double>(target_A)) at_10_ms = t_ms;
    if (at_90_ms < 0 && current_A >= 0.9 * static_cast<double>(target_A)) at_90_ms = t_ms;
    if (t_ms <= 30 || t_ms > 50) return;
    sum_A += current_A;
    ++count;
  };
  bench.set_point_A[coil] = target_A;
  bench.SendCommand();
  bench.RunMs(50);
  bench.each_step = nullptr;
  Response response;
  response.rise_ms = at_90_ms - at_10_ms;
  response.overshoot = largest_A / static_cast<double>(target_A) - 1;
  response.steady_error = std::abs(sum_A / count / static_cast<double>(target_A) - 1);
  return response;
}

struct Case {
  const char* name;
  float target_A;
  double supply_V;
  double copper_C;
  double rise_max_ms;  // ideal: all of the voltage at once, times 1.5
};

class FirmwareStep : public testing::TestWithParam<Case> {};

TEST_P(FirmwareStep, RisesWithoutOvershootAndStays) {
  const Case& c = GetParam();
  for (int coil = 0; coil < wire::kCoils; ++coil) {
    for (const double error : {0.0, 0.03, -0.03}) {  // of what the settings say about the coil
      FirmwarePlant::Options options;
      options.supply_V = c.supply_V;
      options.start_C = c.copper_C;
      options.resistance_error = error;
      options.inductance_error = -3 * error;
      FirmwareBench bench({}, options);
      ASSERT_TRUE(bench.RunToArmed());
      bench.RunMs(10);
      const Response response = StepResponse(bench, coil, c.target_A);
      SCOPED_TRACE(testing::Message() << "coil " << coil << ", error " << error);
      EXPECT_LE(response.overshoot, 0.05);
      EXPECT_LE(response.steady_error, 0.005);
      EXPECT_LE(response.rise_ms, c.rise_max_ms);
      EXPECT_EQ(bench.core.faults(), 0U);
      if (error == 0 && coil == 2) {
        std::printf("  0 -> %g A at %g V, %g C: rise %.2f ms, overshoot %.2f %%, steady error %.3f %%\n",
                    static_cast<double>(c.target_A), c.supply_V, c.copper_C, response.rise_ms, 100 * response.overshoot,
                    100 * response.steady_error);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, FirmwareStep,
                         testing::Values(Case{"To5At12Cold", 5, 12, 24, 1.0}, Case{"To5At12Hot", 5, 12, 45, 1.0},
                                         Case{"To5At18Cold", 5, 18, 24, 1.0}, Case{"To5At18Hot", 5, 18, 55, 1.0},
                                         Case{"To15At12Cold", 15, 12, 24, 3.5}, Case{"To15At12Hot", 15, 12, 40, 4.0},
                                         Case{"To15At18Cold", 15, 18, 24, 2.0}, Case{"To15At18Hot", 15, 18, 47, 2.0}),
                         [](const auto& test) { return test.param.name; });

// The paper's constant force run: its drift compensation, here by closing the loop and tracking the resistance.
TEST(FirmwareCurrent, StaysWithinHalfAPercentOver15MinutesOfHeating) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.set_point_A[1] = 5;
  bench.RunMs(100);
  double worst = 0, worst_ohm = 0, worst_K = 0;
  const double cold_C = bench.plant.temperature_C(1);
  for (int second = 0; second < 15 * 60; ++second) {
    bench.RunMs(1000);
    worst = std::max(worst, std::abs(bench.plant.current_A(1) / 5 - 1));
    const double tracked_ohm = static_cast<double>(bench.core.heat().resistance_ohm(1));
    worst_ohm = std::max(worst_ohm, std::abs(tracked_ohm / bench.plant.resistance_ohm(1) - 1));
    worst_K = std::max(
        worst_K, std::abs(static_cast<double>(bench.core.heat().by_resistance_C(1)) - bench.plant.temperature_C(1)));
  }
  EXPECT_EQ(bench.core.faults(), 0U);
  EXPECT_GT(bench.plant.temperature_C(1), cold_C + 15);
  EXPECT_LE(worst, 0.005);
  EXPECT_LE(worst_ohm, 0.005);
  EXPECT_LE(worst_K, 2);
  std::printf("  5 A for 15 min: %.1f C to %.1f C, current within %.3f %%, resistance within %.3f %%, %.2f K\n", cold_C,
              bench.plant.temperature_C(1), 100 * worst, 100 * worst_ohm, worst_K);
}

TEST(FirmwareCurrent, ShrinksBetweenDerateAndMaxAndTripsOnlyThere) {
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

TEST(FirmwareCurrent, WhereTheVoltageDoesNotSufficeItGivesWhatThereIs) {
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
  // And back without a trace of what could not be reached.
  bench.set_point_A[2] = 5;
  double lowest_A = 15;
  bench.each_step = [&] { lowest_A = std::min(lowest_A, bench.plant.current_A(2)); };
  bench.RunMs(30);
  EXPECT_GT(lowest_A, 5 * 0.97);
  EXPECT_NEAR(bench.plant.current_A(2), 5, 0.03);
}

TEST(FirmwareCurrent, PowerOfAllCoilsIsShared) {
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

TEST(FirmwareCurrent, SlewIsLimited) {
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
TEST(FirmwareCurrent, FollowsWhatTheHostStreams) {
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

TEST(FirmwareCurrent, TelemetrySaysTheMeanOfTheTick) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.set_point_A[0] = 4;
  bench.set_point_A[1] = -6;
  bench.RunMs(30);
  EXPECT_NEAR(bench.telemetry.current[0] * wire::kCurrentUnit_A, 4, 0.02);
  EXPECT_NEAR(bench.telemetry.current[1] * wire::kCurrentUnit_A, -6, 0.02);
  EXPECT_NEAR(bench.telemetry.voltage[1] * wire::kSupplyUnit_V, 6 * bench.plant.resistance_ohm(1), 0.05);
  EXPECT_LT(bench.telemetry.duty[1], 0);
  EXPECT_NEAR(bench.telemetry.resistance[0] * 1e-4, bench.plant.resistance_ohm(0), 0.005);
  EXPECT_NEAR(bench.telemetry.temperature[0] * 0.01, bench.plant.temperature_C(0), 3);
}

}  // namespace
}  // namespace omni::firmware
