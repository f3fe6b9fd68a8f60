// Hall samples as sent to the host: ages, freshness, saturation, and samples that no magnet can cause.
#include <gtest/gtest.h>

#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_hall {

TEST(FirmwareHall, SampleAgesAreRelativeToTheNewest) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunUntil(wire::State::kIdle, 1000));
  std::uint64_t before_us = bench.telemetry_us;
  int fresh = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    bench.RunMs(1);
    EXPECT_GE(bench.telemetry_us, before_us);
    EXPECT_LE(bench.telemetry_us, bench.plant.inputs().now_us);
    before_us = bench.telemetry_us;
    int youngest = 255;
    for (int i = 0; i < wire::kSensors; ++i) {
      youngest = std::min<int>(youngest, bench.telemetry.age[i]);
      // Its age now, less that of the newest, to the rounding of 20 us.
      const double since_newest_us =
          bench.plant.inputs().field_age_us[i] - static_cast<double>(bench.plant.inputs().now_us - bench.telemetry_us);
      EXPECT_NEAR(bench.telemetry.age[i] * 20.0, since_newest_us, 11);
      fresh += (bench.telemetry.fresh_mask >> i) & 1;
    }
    EXPECT_EQ(youngest, 0);
  }
  EXPECT_NEAR(fresh, 8000, 40);  // oscillators run 0 to 0.4 % slow
}

Inputs Quiet(std::uint64_t now_us) {
  Inputs inputs;
  inputs.now_us = now_us;
  inputs.field_answers = inputs.field_fresh = 0xFF;
  inputs.current_answers = 7;
  return inputs;
}

TEST(FirmwareHall, SaturationBeginsAtFullScale) {
  const Settings settings;
  HallWatch watch;
  Inputs inputs = Quiet(1000);
  inputs.field[2][1] = static_cast<std::int16_t>(settings.field_full_scale);
  inputs.field[7][2] = static_cast<std::int16_t>(-settings.field_full_scale);
  inputs.field[0][0] = static_cast<std::int16_t>(settings.field_full_scale - 1);
  watch.Step(settings, inputs);
  EXPECT_EQ(watch.saturated_mask(settings), (1U << 7) | (1U << 23));
}

TEST(FirmwareHall, StuckAfter16EqualSamplesUnlessAllAxesAreClipped) {
  const Settings settings;
  HallWatch watch;
  HallVerdict verdict;
  for (int sample = 0; sample < 17; ++sample) {
    Inputs inputs = Quiet(1000U * (1U + static_cast<unsigned>(sample)));
    for (int i = 0; i < wire::kSensors; ++i) inputs.field[i][0] = static_cast<std::int16_t>(10 * sample);
    inputs.field[4][0] = 77;
    for (std::int16_t& counts : inputs.field[5]) counts = 32767;
    verdict = watch.Step(settings, inputs);
    EXPECT_EQ(verdict.stuck, sample >= RuleOf(wire::kFaultHallStuck).hold ? 1U << 4 : 0U) << sample;
  }
}

TEST(FirmwareHall, SilentAfter5ms) {
  const Settings settings;
  HallWatch watch;
  watch.Step(settings, Quiet(1000));
  Inputs inputs = Quiet(6000);
  inputs.field_fresh = 0xFE;
  EXPECT_EQ(watch.Step(settings, inputs).silent, 0);
  inputs.now_us = 6250;
  EXPECT_EQ(watch.Step(settings, inputs).silent, 1);
}

TEST(FirmwareHall, JumpExplainedByCoilCurrentIsAccepted) {
  const Settings settings;
  for (const bool coils_move : {false, true}) {
    HallWatch watch;
    Inputs inputs = Quiet(1000);
    watch.Step(settings, inputs);
    for (int sample = 2; sample < 5; ++sample) {
      inputs = Quiet(1000U * static_cast<unsigned>(sample));
      inputs.field[0][0] = 16000;  // 9.4 G
      inputs.current[0] = coils_move ? 2400 : 0;
      const HallVerdict verdict = watch.Step(settings, inputs);
      EXPECT_EQ(verdict.jumps, !coils_move && sample == 4 ? 1 : 0) << sample;
      EXPECT_EQ(verdict.fresh & 1, coils_move ? 1 : 0) << sample;
    }
  }
}

}  // namespace test_firmware_hall
}  // namespace omni::firmware
