// What the state memory may contain.
#include "service/protocol/sample_range.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <limits>

namespace omni::protocol {
namespace test_protocol_sample_range {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

ToolSample GoodSample() {
  ToolSample sample;
  sample.t_ns = 5'000'000;
  sample.flags = kToolPoseValid | kToolTracked | kToolAligned;
  sample.position_base_m = {0.01, -0.02, 0.12};
  return sample;
}

const std::function<void(ToolSample&)> kFaults[] = {
    [](ToolSample& s) { s.position_base_m[1] = kNan; },
    [](ToolSample& s) { s.position_base_m[2] = 1e7; },
    [](ToolSample& s) {
      s.orientation_base_wxyz = {0, 0, 0, 0};
    },
    [](ToolSample& s) {
      s.orientation_base_wxyz = {1, 1, 0, 0};
    },
    [](ToolSample& s) { s.orientation_base_wxyz[3] = kInfinite; },
    [](ToolSample& s) { s.linear_velocity_base_m_s[0] = -kInfinite; },
    [](ToolSample& s) { s.angular_velocity_base_rad_s[0] = kNan; },
    [](ToolSample& s) { s.force_base_N[2] = kNan; },
};

TEST(SampleRange, AcceptsDefaultsAndOrdinarySamples) {
  EXPECT_TRUE(InRange(ToolSample{}));
  EXPECT_TRUE(InRange(GoodSample()));
  EXPECT_TRUE(InRange(InputSnapshot{}));
}

TEST(SampleRange, PoseOfABaseIsRefusedIfAnyNumberIsOutOfRange) {
  const std::function<void(BaseSample&)> faults[] = {[](BaseSample& s) { s.t_ns = -1; },
                                                     [](BaseSample& s) { s.flags = 1u << 2; },
                                                     [](BaseSample& s) { s.position_space_m[1] = kNan; },
                                                     [](BaseSample& s) { s.orientation_space_wxyz[0] = 0; },
                                                     [](BaseSample& s) { s.linear_velocity_space_m_s[2] = kInfinite; },
                                                     [](BaseSample& s) { s.angular_velocity_space_rad_s[0] = kNan; }};
  EXPECT_TRUE(InRange(BaseSample{.t_ns = 1, .flags = kBaseSeen | kBaseLeapt}));
  for (const auto& spoil : faults) {
    BaseSample sample;
    spoil(sample);
    EXPECT_FALSE(InRange(sample));
  }
}

TEST(SampleRange, SampleInRangeIsUnchanged) {
  const ToolSample sample = GoodSample();
  const ToolSample clamped = Clamped(sample);
  EXPECT_EQ(clamped.position_base_m, sample.position_base_m);
  EXPECT_EQ(clamped.flags, sample.flags);
}

TEST(SampleRange, InvalidSampleLosesItsPose) {
  for (const auto& spoil : kFaults) {
    ToolSample sample = GoodSample();
    spoil(sample);
    EXPECT_FALSE(InRange(sample));
    const ToolSample clamped = Clamped(sample);
    EXPECT_TRUE(InRange(clamped));
    EXPECT_EQ(clamped.flags, kToolAligned);
    EXPECT_EQ(clamped.t_ns, sample.t_ns);
  }
}

TEST(SampleRange, NonFiniteGapOrSigmaIsClampedAndKeepsThePose) {
  ToolSample sample = GoodSample();
  sample.gap_m = kInfinite;
  sample.position_sigma_m = kNan;
  EXPECT_FALSE(InRange(sample));
  const ToolSample clamped = Clamped(sample);
  EXPECT_EQ(clamped.gap_m, kLargestValue);
  EXPECT_EQ(clamped.position_sigma_m, kLargestValue);
  EXPECT_EQ(clamped.flags, sample.flags);
}

TEST(SampleRange, FlagsAndTimesAreBounded) {
  ToolSample sample = GoodSample();
  sample.flags |= 1u << 31;
  EXPECT_FALSE(InRange(sample));
  EXPECT_EQ(Clamped(sample).flags, GoodSample().flags);
  sample = GoodSample();
  sample.t_ns = -1;
  EXPECT_FALSE(InRange(sample));
  EXPECT_EQ(Clamped(sample).t_ns, 0);
  sample.t_ns = std::numeric_limits<std::int64_t>::max();
  EXPECT_FALSE(InRange(sample));
  EXPECT_EQ(Clamped(sample).t_ns, kLatestTime_ns);
}

TEST(SampleRange, InputsAreClamped) {
  InputSnapshot inputs;
  inputs.components[0].value = std::numeric_limits<float>::quiet_NaN();
  inputs.components[1].value = 3;
  inputs.components[2].value = -3;
  inputs.components[3].t_change_ns = -5;
  inputs.components[3].press_count = 4;
  EXPECT_FALSE(InRange(inputs));
  const InputSnapshot clamped = Clamped(inputs);
  EXPECT_TRUE(InRange(clamped));
  EXPECT_EQ(clamped.components[0].value, 0);
  EXPECT_EQ(clamped.components[1].value, 1);
  EXPECT_EQ(clamped.components[2].value, -1);
  EXPECT_EQ(clamped.components[3].press_count, 4u);
}

TEST(SampleRange, TelemetryIsClampedNumberByNumber) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  TelemetrySample telemetry;
  telemetry.tick_faults = 5;
  telemetry.current_A = {1, kNaN, -2};
  telemetry.tip_variance_m2 = {kInfinity, 1e-9F};
  telemetry.supply_V = -kInfinity;
  EXPECT_FALSE(InRange(telemetry));
  const TelemetrySample clamped = Clamped(telemetry);
  EXPECT_TRUE(InRange(clamped));
  EXPECT_EQ(clamped.tick_faults, 5U);
  EXPECT_EQ(clamped.current_A, (std::array<float, 3>{1, 0, -2}));
  EXPECT_EQ(clamped.tip_variance_m2, (std::array<float, 2>{1e6F, 1e-9F}));
  EXPECT_EQ(clamped.supply_V, -1e6F);
}

// No number of the sample escapes the check.
TEST(SampleRange, EveryNumberOfTelemetryIsChecked) {
  constexpr std::size_t kNumbers = 3 + 3 + 3 + 3 + 2 + 6;
  constexpr std::size_t kFirst = offsetof(TelemetrySample, current_A);
  static_assert(kFirst + kNumbers * sizeof(float) == sizeof(TelemetrySample));
  for (std::size_t i = 0; i < kNumbers; ++i) {
    TelemetrySample telemetry;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(reinterpret_cast<char*>(&telemetry) + kFirst + i * sizeof(float), &nan, sizeof(nan));
    EXPECT_FALSE(InRange(telemetry)) << i;
    EXPECT_TRUE(InRange(Clamped(telemetry))) << i;
  }
}

}  // namespace test_protocol_sample_range
}  // namespace omni::protocol
