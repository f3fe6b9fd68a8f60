#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "service/loop/histogram.h"
#include "service/loop/inputs.h"

namespace omni::loop {
namespace test_loop_inputs {

using base::InputComponent;

const base::InputValue& Get(const InputTracker& tracker, InputComponent component) {
  return tracker.inputs.components[static_cast<std::size_t>(component)];
}

// One tick with the default mapping.
void Update(const InputConfig& config, const haptics::Output& haptics, bool live, std::int64_t t_ns,
            InputTracker& tracker) {
  UpdateInputs(config, base::DefaultMapping(), {.t_ns = t_ns, .live = live, .owned = true, .tracked = live}, haptics,
               nullptr, tracker);
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
    Update(config, Pressing(forces[i]), true, 1000 + i, tracker);
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
    Update(config, Pressing(1), true, 10 * i, tracker);
    Update(config, Pressing(0), true, 10 * i + 5, tracker);
  }
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).press_count, 7U);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).release_count, 7U);
}

TEST(Inputs, ComponentsRestWhenNotLive) {
  const InputConfig config{.force_filter_s = 0};
  InputTracker tracker;
  haptics::Output output = Pressing(1);
  output.joystick = true;
  output.thumbstick_x = 0.7;
  Update(config, output, true, 1, tracker);
  EXPECT_FLOAT_EQ(Get(tracker, InputComponent::kThumbstickX).value, 0.7F);
  Update(config, output, false, 2, tracker);
  for (const auto& component : tracker.inputs.components) EXPECT_EQ(component.value, 0);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).release_count, 1U);
}

TEST(Inputs, ForceSpikesDoNotSelect) {
  const InputConfig config;
  InputTracker tracker;
  for (int ms = 0; ms < 1000; ++ms) {  // 0.1 N with spikes of 0.3 N, 1 ms long
    Update(config, Pressing(ms % 20 == 0 ? 0.3 : 0.1), true, ms * 1'000'000LL, tracker);
  }
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).press_count, 0U);
  for (int ms = 1000; ms < 1100; ++ms) Update(config, Pressing(0.3), true, ms * 1'000'000LL, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).press_count, 1U);
}

TEST(Inputs, ThumbstickIsZeroWithoutJoystick) {
  InputTracker tracker;
  haptics::Output output;
  output.thumbstick_y = 1;
  Update({.force_filter_s = 0}, output, true, 1, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kThumbstickY).value, 0);
}

TEST(Inputs, ChangesBelowResolutionAreIgnored) {
  InputTracker tracker;
  Update({.force_filter_s = 0}, Pressing(0.5), true, 1, tracker);
  Update({.force_filter_s = 0}, Pressing(0.5005), true, 2, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kTipForce).t_change_ns, 1);
  Update({.force_filter_s = 0}, Pressing(0.51), true, 3, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kTipForce).t_change_ns, 3);
}

TEST(Inputs, NonFiniteForceReadsAsZero) {
  InputTracker tracker;
  Update({.force_filter_s = 0}, Pressing(std::numeric_limits<double>::quiet_NaN()), true, 1, tracker);
  EXPECT_EQ(Get(tracker, InputComponent::kTipForce).value, 0);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).value, 0);
}

// A mapping of one key only.
base::InputMapping KeyMapping(int slot, InputComponent component) {
  base::InputMapping mapping;
  mapping.at(component).plus = base::KeyBit(slot);
  return mapping;
}

class Keys : public testing::Test {
 protected:
  void Press(std::int64_t t_ns, int slot = 0) {
    ++states_.slots[static_cast<std::size_t>(slot)].press_count;
    states_.slots[static_cast<std::size_t>(slot)].t_press_ns = t_ns;
  }
  void Release(std::int64_t t_ns, int slot = 0) {
    ++states_.slots[static_cast<std::size_t>(slot)].release_count;
    states_.slots[static_cast<std::size_t>(slot)].t_release_ns = t_ns;
  }
  // A pen that is nowhere: keys need none.
  const base::InputValue& Tick(const base::InputMapping& mapping, std::int64_t t_ns, bool owned = true,
                               InputComponent seen = InputComponent::kSecondary) {
    UpdateInputs({}, mapping, {.t_ns = t_ns, .owned = owned}, {}, &states_, tracker_);
    return Get(tracker_, seen);
  }
  base::KeyStates states_;
  InputTracker tracker_;
};

TEST_F(Keys, PressAndReleaseKeepTheirOwnTimes) {
  const base::InputMapping mapping = KeyMapping(3, InputComponent::kSecondary);
  EXPECT_EQ(Tick(mapping, 1'000'000).value, 0);
  Press(1'200'345, 3);
  EXPECT_EQ(Tick(mapping, 2'000'000).value, 1);
  EXPECT_EQ(Tick(mapping, 2'000'000).t_change_ns, 1'200'345);
  EXPECT_EQ(Tick(mapping, 3'000'000).press_count, 1U);
  Release(3'400'001, 3);
  EXPECT_EQ(Tick(mapping, 4'000'000).value, 0);
  EXPECT_EQ(Tick(mapping, 5'000'000).t_change_ns, 3'400'001);
  EXPECT_EQ(Tick(mapping, 5'000'000).release_count, 1U);
}

// What a keyboard does between two ticks is neither lost nor doubled, whatever the interleaving.
TEST_F(Keys, CountsEveryPressBetweenTicks) {
  const base::InputMapping mapping = KeyMapping(0, InputComponent::kSecondary);
  std::mt19937 random(20263);
  std::uint32_t pressed = 0;
  std::int64_t t_ns = 1'000'000;
  bool down = false;
  Tick(mapping, t_ns);
  for (int i = 0; i < 2000; ++i) {
    for (auto edges = static_cast<std::int64_t>(random() % 4); edges > 0; --edges) {
      down ? Release(t_ns + edges) : Press(t_ns + edges);
      pressed += down ? 0 : 1;
      down = !down;
    }
    for (auto ticks = 8 + random() % 3; ticks > 0; --ticks) Tick(mapping, t_ns += 1'000'000);
    const base::InputValue& value = Get(tracker_, InputComponent::kSecondary);
    ASSERT_EQ(value.press_count, pressed) << i;
    ASSERT_EQ(value.release_count, down ? pressed - 1 : pressed) << i;
    ASSERT_EQ(value.value, down ? 1 : 0) << i;
  }
  EXPECT_GT(pressed, 500U);
}

TEST_F(Keys, IgnoresKeysWithoutAnOwner) {
  const base::InputMapping mapping = KeyMapping(0, InputComponent::kSecondary);
  Press(10);
  EXPECT_EQ(Tick(mapping, 1'000'000, false).value, 0) << "no application owns the force";
  EXPECT_EQ(Tick(mapping, 2'000'000).value, 0) << "held since before: not a press for the new owner";
  Release(20);
  Press(30);
  Tick(mapping, 3'000'000);
  EXPECT_EQ(Tick(mapping, 4'000'000).value, 1);
  EXPECT_EQ(Tick(mapping, 5'000'000, false).value, 0) << "the owner is gone";
  EXPECT_EQ(Tick(mapping, 6'000'000).press_count, 1U);
}

TEST_F(Keys, AnAxisHasKeysOfBothSigns) {
  base::InputMapping mapping;
  mapping.at(InputComponent::kThumbstickX) = {.plus = base::KeyBit(0), .minus = base::KeyBit(1)};
  Tick(mapping, 1'000'000);
  Press(5, 1);
  EXPECT_EQ(Tick(mapping, 2'000'000, true, InputComponent::kThumbstickX).value, -1);
  Press(6, 0);
  EXPECT_EQ(Tick(mapping, 3'000'000, true, InputComponent::kThumbstickX).value, 0);
  Release(7, 1);
  EXPECT_EQ(Tick(mapping, 4'000'000, true, InputComponent::kThumbstickX).value, 1);
}

TEST_F(Keys, SourcesOfOneComponentActAsOneButton) {
  base::InputMapping mapping;
  mapping.at(InputComponent::kSecondary).plus = base::KeyBit(0) | base::KeyBit(1);
  Tick(mapping, 1'000'000);
  Press(5, 0);
  Tick(mapping, 2'000'000);
  Press(6, 1);
  Tick(mapping, 3'000'000);
  Release(7, 0);
  EXPECT_EQ(Tick(mapping, 4'000'000).value, 1) << "the other is still down";
  Release(8, 1);
  EXPECT_EQ(Tick(mapping, 5'000'000).value, 0);
  EXPECT_EQ(Get(tracker_, InputComponent::kSecondary).press_count, 1U);
  EXPECT_EQ(Get(tracker_, InputComponent::kSecondary).t_change_ns, 8);
}

TEST(Inputs, FollowsTheInputMapping) {
  base::InputMapping mapping;
  mapping.at(InputComponent::kMenu).plus = SourceBit(base::InputSource::kPress);
  mapping.thresholds.press_N = 0.5;
  mapping.thresholds.release_N = 0.4;
  InputTracker tracker;
  const auto tick = [&](double force_N, std::int64_t t_ns) {
    UpdateInputs({.force_filter_s = 0}, mapping, {.t_ns = t_ns, .live = true, .tracked = true}, Pressing(force_N),
                 nullptr, tracker);
  };
  tick(0.45, 1'000'000);
  EXPECT_EQ(Get(tracker, InputComponent::kMenu).value, 0);
  tick(0.55, 2'000'000);
  EXPECT_EQ(Get(tracker, InputComponent::kMenu).value, 1);
  EXPECT_EQ(Get(tracker, InputComponent::kSelect).value, 0);
  tick(0.45, 3'000'000);
  EXPECT_EQ(Get(tracker, InputComponent::kMenu).value, 1);
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

}  // namespace test_loop_inputs
}  // namespace omni::loop
