// Vibrations in the tick: the commanded force is the requested one, sample by sample, and never over its limit.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <random>

#include "service/haptics/scene/scene.h"
#include "service/loop/vibration.h"
#include "tests/support/touch/scenario.h"

namespace omni::loop {
namespace test_loop_vibration {

constexpr double kTick_s = 1e-3;

std::unique_ptr<VibrationSamples> Samples(std::uint64_t id, const std::vector<float>& values) {
  auto samples = std::make_unique<VibrationSamples>();
  samples->id = id;
  samples->count = static_cast<std::uint32_t>(values.size());
  std::copy(values.begin(), values.end(), samples->values.begin());
  return samples;
}

HapticWaveform Envelope(double duration_s) {
  return {.id = 1, .active = true, .kind = VibrationKind::kEnvelope, .duration_s = duration_s};
}
HapticWaveform Pcm(std::uint64_t id = 1) { return {.id = id, .active = true, .kind = VibrationKind::kPcm}; }

TEST(MeanBetween, MatchesTheMeanOfTheSampleStaircase) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int round = 0; round < 200; ++round) {
    std::vector<float> samples(1 + random() % 50);
    for (float& sample : samples) sample = static_cast<float>(2 * uniform(random) - 1);
    const double size = static_cast<double>(samples.size());
    const double from = size * uniform(random), to = from + 5 * uniform(random) + 1e-3;
    const double end = std::min(to, size);
    double sum = 0;
    constexpr int kSteps = 20'000;
    for (int i = 0; i < kSteps; ++i) {
      sum += static_cast<double>(samples[static_cast<std::size_t>(from + (end - from) * (i + 0.5) / kSteps)]);
    }
    EXPECT_NEAR(MeanBetween(samples, from, to), sum / kSteps, 2e-4) << round;
  }
  const std::vector<float> nonsense{std::nanf(""), 2.0F, -INFINITY, 0.5F};
  EXPECT_EQ(MeanBetween(nonsense, 0, 3), 0);
  EXPECT_EQ(MeanBetween(nonsense, 3, 4), 0.5);
  EXPECT_EQ(MeanBetween(nonsense, 4, 5), 0);
  EXPECT_EQ(MeanBetween(nonsense, -1, 1), 0);
  EXPECT_EQ(MeanBetween(nonsense, std::nan(""), 1), 0);
}

TEST(Vibration, PcmAtTickRateIsPlayedUnchanged) {
  const VibrationConfig config;
  std::mt19937 random(8);
  std::vector<float> values(4000);
  for (float& value : values) value = static_cast<float>(random() % 2001) / 1000.0F - 1.0F;
  const auto samples = Samples(1, values);
  VibrationState state;
  for (std::size_t i = 0; i < values.size(); ++i) {
    ASSERT_EQ(VibrationForce_N(config, Pcm(), samples.get(), kTick_s, state),
              config.force_N * static_cast<double>(values[i]))
        << i;
  }
  EXPECT_EQ(VibrationForce_N(config, Pcm(), samples.get(), kTick_s, state), 0) << "and then silence";
}

TEST(Vibration, PcmContinuesWithAppendedSamplesAndWaitsForThem) {
  const VibrationConfig config{.force_N = 1};
  VibrationState state;
  auto samples = Samples(1, {0.5F, 0.25F});
  EXPECT_EQ(VibrationForce_N(config, Pcm(), nullptr, kTick_s, state), 0) << "samples have not come yet";
  EXPECT_EQ(VibrationForce_N(config, Pcm(), samples.get(), kTick_s, state), 0.5);
  EXPECT_EQ(VibrationForce_N(config, Pcm(), samples.get(), kTick_s, state), 0.25);
  EXPECT_EQ(VibrationForce_N(config, Pcm(), samples.get(), kTick_s, state), 0);
  samples->first = 1;  // the first was played; one more was appended
  samples->values[0] = 0.25F;
  samples->values[1] = -0.75F;
  EXPECT_EQ(VibrationForce_N(config, Pcm(), samples.get(), kTick_s, state), -0.75);
  EXPECT_EQ(VibrationForce_N(config, Pcm(), samples.get(), kTick_s, state), 0);
  const auto other = Samples(2, {1.0F});
  EXPECT_EQ(VibrationForce_N(config, Pcm(2), samples.get(), kTick_s, state), 0) << "those of another waveform";
  EXPECT_EQ(VibrationForce_N(config, Pcm(2), other.get(), kTick_s, state), 1);
}

// The force under an envelope: its size in each piece of 50 ms is that of the envelope there.
TEST(Vibration, TheForceFollowsTheEnvelope) {
  const VibrationConfig config;
  for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{60}, std::size_t{4000}}) {
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) {
      values[i] = 0.5F + 0.4F * static_cast<float>(std::sin(6.0 * static_cast<double>(i) / static_cast<double>(count)));
    }
    const auto samples = Samples(1, values);
    VibrationState state;
    constexpr int kTicks = 1500;
    double worst = 0;
    std::vector<double> force_N(kTicks);
    for (double& f : force_N) f = VibrationForce_N(config, Envelope(1.5), samples.get(), kTick_s, state);
    for (int piece = 0; piece < 30; ++piece) {
      double felt = 0, wanted = 0;
      for (int i = 50 * piece; i < 50 * piece + 50; ++i) {
        felt += force_N[static_cast<std::size_t>(i)] * force_N[static_cast<std::size_t>(i)];
        const auto sample = static_cast<double>(values[static_cast<std::size_t>(i) * count / kTicks]);
        wanted += 0.5 * sample * sample * config.force_N * config.force_N;
      }
      worst = std::max(worst, std::abs(std::sqrt(felt / wanted) - 1));
    }
    EXPECT_LT(worst, 0.05) << count << " samples";
    VibrationForce_N(config, Envelope(1.5), samples.get(), kTick_s, state);  // sums of milliseconds round
    EXPECT_EQ(VibrationForce_N(config, Envelope(1.5), samples.get(), kTick_s, state), 0) << "it is over";
    EXPECT_FALSE(state.playing);
  }
}

TEST(Vibration, ShortestEnvelopeLasts20MillisecondsAndZeroPlaysNothing) {
  const VibrationConfig config;
  const auto samples = Samples(1, {1.0F});
  VibrationState state;
  int ticks = 0;
  for (int i = 0; i < 100; ++i) {
    ticks += VibrationForce_N(config, Envelope(-1), samples.get(), kTick_s, state) != 0 ? 1 : 0;
  }
  EXPECT_NEAR(ticks, 20, 1);
  VibrationState other;
  EXPECT_EQ(VibrationForce_N(config, Envelope(0), samples.get(), kTick_s, other), 0);
}

// For any samples and requests: a force within +- force_N.
TEST(Vibration, NeverExceedsItsForceLimit) {
  const VibrationConfig config;
  std::mt19937_64 random(9);
  const double odd[] = {0, 1, -1, 1e300, -1e300, std::nan(""), INFINITY, -INFINITY, 0.01, 250, 1e-300};
  const auto pick = [&] { return odd[random() % std::size(odd)]; };
  auto samples = std::make_unique<VibrationSamples>();
  VibrationState state;
  for (int i = 0; i < 100'000; ++i) {
    samples->id = random() % 3;
    samples->first = random() % 4 == 0 ? random() : random() % 10;
    samples->count = static_cast<std::uint32_t>(random() % 5 == 0 ? random() : random() % kMaxVibrationSamples);
    samples->values[random() % 20] = static_cast<float>(pick());
    const HapticWaveform waveform{.id = random() % 3,
                                  .active = random() % 10 != 0,
                                  .kind = static_cast<VibrationKind>(random() % 3),
                                  .duration_s = pick(),
                                  .amplitude = pick(),
                                  .frequency_Hz = pick()};
    const double force_N = VibrationForce_N(config, waveform, samples.get(), kTick_s, state);
    ASSERT_TRUE(std::abs(force_N) <= config.force_N) << i;
  }
}

// The bandwidth: the response of "one force per millisecond, held" with the coils' lag, by the theory of the sampled
// hold.
TEST(Vibration, BandwidthMatchesDocumentation) {
  const auto response = [](double f_Hz) {
    const double x = std::numbers::pi * f_Hz * 1e-3;
    const double hold = std::sin(x) / x;
    const double lag = 1 / std::sqrt(1 + std::pow(2 * std::numbers::pi * f_Hz * 0.35e-3, 2));
    return hold * lag;
  };
  double edge_Hz = 1;
  while (response(edge_Hz) > std::numbers::sqrt2 / 2) edge_Hz += 1;
  std::printf("held for 1 ms with a coil lag of 0.35 ms: half the power at %.0f Hz, %.2f at 100 Hz, %.2f at 400 Hz\n",
              edge_Hz, response(100), response(400));
  EXPECT_NEAR(edge_Hz, 300, 30);
}

// The whole loop: contact and PCM together stay within what the coils can do, and PCM alone is what was requested.
TEST(VibrationScenario, PcmAddsToContactWithinTheSameLimits) {
  const haptics::Scene table = test::TableScene(test::kTableTop_m);
  test::Scenario scenario(test::PressAndSlide(), 4.0);
  std::vector<float> values(4000);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<float>(std::sin(2 * std::numbers::pi * 120 * 1e-3 * static_cast<double>(i)));
  }
  const auto samples = Samples(5, values);
  scenario.feeds.samples = samples.get();
  int alone = 0, with_contact = 0;
  while (scenario.Step(table, [&](const base::HallScan& scan) {
    Commands commands = test::Scenario::Open(scan);
    commands.haptic = {.id = 5, .active = true, .kind = VibrationKind::kPcm};
    return commands;
  })) {
    const TickOutput& o = scenario.output;
    for (const double current_A : o.currents.current_A) {
      ASSERT_TRUE(std::abs(current_A) <= config::DefaultDevice().current_max_A + 1e-9) << o.tick;
    }
    if (o.haptics.in_contact) {
      ++with_contact;
      continue;
    }
    if (o.gate < 1 || o.haptics.force_base_N != base::Vec3{} || o.tick >= values.size()) continue;
    const base::Vec3 u = o.tool.axis_base;
    const double felt_N = o.wrench.force_N.x * u.x + o.wrench.force_N.y * u.y + o.wrench.force_N.z * u.z;
    const double asked_N = scenario.config.vibration.force_N * static_cast<double>(values[o.tick]);
    ASSERT_LE(std::abs(felt_N), std::abs(asked_N) + 1e-9) << o.tick;
    alone += std::abs(felt_N - asked_N) < 1e-6 ? 1 : 0;
  }
  EXPECT_GT(alone, 300);
  EXPECT_GT(with_contact, 500);
}

}  // namespace test_loop_vibration
}  // namespace omni::loop
