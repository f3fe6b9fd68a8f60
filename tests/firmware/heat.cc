// The two estimates of the coils' temperatures.
#include <gtest/gtest.h>

#include "firmware/core/safety/coil_heat.h"
#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_heat {

// The paper's run of coil y: 25 s of 15 A from 24 C. Its thermometer showed 39 C 40 s later: the body.
TEST(FirmwareHeat, TwoNodeModelMatchesThePaper) {
  const Settings settings;
  CoilHeat heat(settings);
  CoilSample samples[wire::kCoils];
  for (int step = 0; step < 65 * 4000; ++step) {
    samples[1].current_A = step < 25 * 4000 ? 15.0F : 0.0F;
    heat.Step(settings, samples);
  }
  EXPECT_NEAR(heat.body_C(), 39, 1.5);
}

// A coil whose resistance is not measured (no current, or a wrong voltage) still counts as hot.
TEST(FirmwareHeat, TemperatureIsTheHotterOfBothEstimates) {
  const Settings settings;
  CoilHeat heat(settings);
  CoilSample samples[wire::kCoils];
  for (int step = 0; step < 20 * 4000; ++step) {
    samples[0] = {10, 10 * settings.coils[0].resistance_20C_ohm, true};  // corresponds to 20 C all the time
    heat.Step(settings, samples);
  }
  EXPECT_NEAR(heat.by_resistance_C(0), 20, 2);
  EXPECT_GT(heat.by_heat_C(0), 40);
  EXPECT_EQ(heat.temperature_C(0), heat.by_heat_C(0));

  for (int step = 0; step < 4000; ++step) {
    samples[0].voltage_V = 10 * ResistanceAt(settings, 0, 65);
    heat.Step(settings, samples);
  }
  EXPECT_NEAR(heat.by_resistance_C(0), 65, 1);
  EXPECT_EQ(heat.temperature_C(0), heat.by_resistance_C(0));
}

// Below an ampere nothing is measured; what was measured cools along with the model.
TEST(FirmwareHeat, EstimateFollowsCoolingWithoutCurrent) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.SetAll(12);
  bench.RunMs(10'000);
  bench.SetAll(0);
  bench.RunMs(30'000);
  EXPECT_GT(bench.plant.temperature_C(1), 30);
  EXPECT_NEAR(bench.core.heat().by_resistance_C(1), bench.plant.temperature_C(1), 1.5);
  EXPECT_EQ(bench.core.faults(), 0U);
}

}  // namespace test_firmware_heat
}  // namespace omni::firmware
