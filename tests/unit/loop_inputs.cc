#include <gtest/gtest.h>

#include <limits>

#include "service/loop/histogram.h"
#include "service/loop/inputs.h"

namespace omni::loop {
namespace {

using base::InputComponent;

const base::InputValue& Get(const InputTracker& tracker, InputComponent component) {
  return tracker.inputs.components[static_cast<std::size_t>(component)];
}

haptics::Output Pressing(double force_N) {
  haptics::Output output;
  output.tip_normal_force_N = force_N;
  return output;
}

TEST(Inputs, SelectHasHysteresis) {
  const InputConfig config{.force_filter_s = 0};
  InputTracker tracker;
  const double forces[] = {0.14, 0.16, 0.10, 0.09, 0.07, 0.14};
  const float expected[] = {0, 1, 1, 1, 0, 0};
  for (int i = 0; i < 6; ++i) {
    UpdateInputs(config, Pressing(forces[i]), true, 1000 + i, tracker);
    EXPECT_EQ(Get(tracker, InputComponent::kSelect).value, expected[i]) << i;
  }
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).press_count, 1U);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).release_count, 1U);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).t_change_ns, 1004);
}

TEST(Inputs, EveryPressIsCounted) {
  const InputConfig config{.force_filter_s = 0};
  InputTracker tracker;
  for (int i = 0; i < 7; ++i) {
    UpdateInputs(config, Pressing(1), true, 10 * i, tracker);
    UpdateInputs(config, Pressing(0), true, 10 * i + 5, tracker);
  }
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).press_count, 7U);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).release_count, 7U);
}

TEST(Inputs, NotLiveGoesToRest) {
  const InputConfig config{.force_filter_s = 0};
  InputTracker tracker;
  haptics::Output output = Pressing(1);
  output.joystick = true;
  output.thumbstick_x = 0.7;
  UpdateInputs(config, output, true, 1, tracker);
  EXPECT_FLOAT_EQ(Get(tracker, InputComponent::kThumbstickX).value, 0.7F);
  UpdateInputs(config, output, false, 2, tracker);
  for (const auto& component : tracker.inputs.components) EXPECT_EQ(component.value, 0);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).release_count, 1U);
}

TEST(Inputs, NoiseDoesNotClick) {
  const InputConfig config;
  InputTracker tracker;
  for (int ms = 0; ms < 1000; ++ms) {  // 0.1 N with spikes of 0.3 N, 1 ms long
    UpdateInputs(config, Pressing(ms % 20 == 0 ? 0.3 : 0.1), true, ms * 1'000'000LL, tracker);
  }
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).press_count, 0U);
  for (int ms = 1000; ms < 1100; ++ms) UpdateInputs(config, Pressing(0.3), true, ms * 1'000'000LL, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).press_count, 1U);
}

TEST(Inputs, NoJoystickNoThumbstick) {
  InputTracker tracker;
  haptics::Output output;
  output.thumbstick_y = 1;
  UpdateInputs({.force_filter_s = 0}, output, true, 1, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kThumbstickY).value, 0);
}

TEST(Inputs, TinyChangesAreNotChanges) {
  InputTracker tracker;
  UpdateInputs({.force_filter_s = 0}, Pressing(0.5), true, 1, tracker);
  UpdateInputs({.force_filter_s = 0}, Pressing(0.5005), true, 2, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kTipForce).t_change_ns, 1);
  UpdateInputs({.force_filter_s = 0}, Pressing(0.51), true, 3, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kTipForce).t_change_ns, 3);
}

TEST(Inputs, NotFiniteReadsAsRest) {
  InputTracker tracker;
  UpdateInputs({.force_filter_s = 0}, Pressing(std::numeric_limits<double>::quiet_NaN()), true, 1, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kTipForce).value, 0);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).value, 0);
}

TEST(Histogram, QuantilesAreWithinABucket) {
  Histogram histogram;
  EXPECT_EQ(histogram.Quantile_us(0.5), 0);
  for (int i = 1; i <= 100'000; ++i) histogram.Add(i);  // 1 ns .. 100 us, uniform
  EXPECT_EQ(histogram.count(), 100'000U);
  EXPECT_NEAR(histogram.Quantile_us(0.5), 50, 50 * 0.13);
  EXPECT_NEAR(histogram.Quantile_us(0.99), 99, 99 * 0.13);
  EXPECT_DOUBLE_EQ(histogram.max_us(), 100);
}

TEST(Histogram, ExtremesHaveABucket) {
  Histogram histogram;
  histogram.Add(-5);
  histogram.Add(0);
  histogram.Add(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_GT(histogram.Quantile_us(1), 1e12);
}

}  // namespace
}  // namespace omni::loop
