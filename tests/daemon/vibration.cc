// Requested vibrations on their way to the tick: replaced, appended, resampled, bounded.
#include "service/daemon/clients/vibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <string>

namespace omni::daemon {
namespace test_daemon_vibration {

constexpr std::int64_t kMs = 1'000'000;

// Owns the bytes that its message points into.
struct Sent {
  std::string bytes;
  protocol::Waveform waveform;
  protocol::ShapedHaptic haptic() const { return {waveform, bytes}; }
};

Sent Make(protocol::WaveformKind kind, const std::vector<float>& values) {
  Sent sent;
  sent.waveform.kind = kind;
  sent.waveform.count = static_cast<std::uint32_t>(values.size());
  sent.bytes.assign(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  return sent;
}

Sent Pcm(const std::vector<float>& values, float rate_Hz, bool append) {
  Sent sent = Make(protocol::WaveformKind::kPcm, values);
  sent.waveform.sample_rate_Hz = rate_Hz;
  sent.waveform.append = append ? 1 : 0;
  return sent;
}

std::vector<float> Ramp(std::size_t count, float scale) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = scale * static_cast<float>(i) / static_cast<float>(count);
  return values;
}

std::vector<float> Held(const Vibration& vibration) {
  const loop::VibrationSamples& s = vibration.samples();
  return {s.values.begin(), s.values.begin() + s.count};
}

TEST(DaemonVibration, ALaterEventReplacesTheEarlier) {
  Vibration vibration;
  vibration.PlayTone({.duration_ns = 5 * kMs, .amplitude = 0.5F, .frequency_Hz = 100});
  EXPECT_EQ(vibration.waveform().id, 1u);
  EXPECT_DOUBLE_EQ(vibration.waveform().duration_s, 0.005);
  EXPECT_FALSE(vibration.PopFresh());
  Sent envelope = Make(protocol::WaveformKind::kEnvelope, {0, 1, 0.5F});
  envelope.waveform.duration_ns = 300 * kMs;
  vibration.PlayShaped(envelope.haptic(), 0);
  EXPECT_EQ(vibration.waveform().id, 2u);
  EXPECT_EQ(vibration.waveform().kind, loop::VibrationKind::kEnvelope);
  EXPECT_DOUBLE_EQ(vibration.waveform().duration_s, 0.3);
  EXPECT_EQ(vibration.samples().id, 2u);
  EXPECT_EQ(Held(vibration), (std::vector<float>{0, 1, 0.5F}));
  EXPECT_TRUE(vibration.PopFresh());
  vibration.PlayShaped(Pcm({1, -1}, 1000, false).haptic(), 0);
  EXPECT_EQ(vibration.waveform().id, 3u);
  EXPECT_EQ(Held(vibration), (std::vector<float>{1, -1}));
  vibration.Stop();
  EXPECT_FALSE(vibration.waveform().active);
  vibration.PlayShaped(Pcm({0.5F}, 1000, true).haptic(), 1);
  EXPECT_EQ(vibration.waveform().id, 4u) << "a stopped vibration is not continued";
}

TEST(DaemonVibration, AppendsPcmOfAnySampleRate) {
  Vibration vibration;
  const std::vector<float> first = Ramp(200, 1), second = Ramp(300, -1);
  vibration.PlayShaped(Pcm(first, 1000, true).haptic(), 10 * kMs);
  const std::uint64_t id = vibration.waveform().id;
  vibration.PlayShaped(Pcm(second, 1000, true).haptic(), 50 * kMs);
  EXPECT_EQ(vibration.waveform().id, id);
  std::vector<float> all = first;
  all.insert(all.end(), second.begin(), second.end());
  EXPECT_EQ(Held(vibration), all);
  vibration.PlayShaped(Pcm(std::vector<float>(800, 0.25F), 8000, true).haptic(), 60 * kMs);
  EXPECT_EQ(vibration.samples().count, 600u) << "800 samples at 8 kHz are 100 ms";
  EXPECT_EQ(Held(vibration).back(), 0.25F);
  vibration.PlayShaped(Pcm({0.5F}, 1000, true).haptic(), 700 * kMs);
  EXPECT_EQ(vibration.waveform().id, id + 1) << "all has been played: a new effect";
  EXPECT_EQ(Held(vibration), std::vector<float>{0.5F});
  vibration.PlayShaped(Pcm({0.75F}, 1000, false).haptic(), 700 * kMs);
  EXPECT_EQ(vibration.waveform().id, id + 2);
}

// A stream without end: the window holds what is to come, in its place, and nothing overflows.
TEST(DaemonVibration, EndlessPcmStreamKeepsItsPositions) {
  Vibration vibration;
  std::mt19937 random(2);
  std::int64_t now_ns = 0;
  std::vector<float> all;
  for (int i = 0; i < 2000; ++i) {
    const std::size_t size = 1 + random() % 60;
    std::vector<float> chunk(size);
    for (float& value : chunk) value = static_cast<float>(random() % 1000) / 1000.0F;
    all.insert(all.end(), chunk.begin(), chunk.end());
    vibration.PlayShaped(Pcm(chunk, 1000, true).haptic(), now_ns);
    const loop::VibrationSamples& s = vibration.samples();
    ASSERT_EQ(s.first + s.count, all.size());
    for (std::uint32_t k = 0; k < s.count; ++k) ASSERT_EQ(s.values[k], all[s.first + k]) << i;
    const auto played = static_cast<std::uint64_t>(now_ns / kMs);
    ASSERT_LE(s.first, played) << "nothing is dropped that has not been played";
    const std::int64_t ahead_ns = static_cast<std::int64_t>(all.size()) * kMs - now_ns;
    now_ns +=
        ahead_ns > 3000 * kMs ? static_cast<std::int64_t>(size) * kMs : static_cast<std::int64_t>(random() % 20) * kMs;
    now_ns = std::min(now_ns, static_cast<std::int64_t>(all.size()) * kMs - 1);
  }
  EXPECT_EQ(vibration.waveform().id, 1u);
  EXPECT_GT(vibration.samples().first, 10'000u);
}

TEST(DaemonVibration, DropsSamplesThatDoNotFit) {
  Vibration vibration;
  for (int i = 0; i < 10; ++i) vibration.PlayShaped(Pcm(std::vector<float>(4000, 1), 1000, true).haptic(), 0);
  EXPECT_EQ(vibration.samples().count, loop::kMaxVibrationSamples);
  vibration.PlayShaped(Pcm(std::vector<float>(4000, 1), 0.001F, false).haptic(), 0);
  EXPECT_LE(vibration.samples().count, loop::kMaxVibrationSamples);
}

// A tone below half the coils' rate comes through resampling with the gain of a mean over a millisecond.
TEST(DaemonVibration, ResamplesToTheMeanOfEachMillisecond) {
  for (const double rate_Hz : {300.0, 999.0, 1000.0, 4410.0, 8000.0, 48000.0}) {
    for (const double tone_Hz : {20.0, 80.0, 120.0}) {
      if (tone_Hz > 0.2 * rate_Hz) continue;
      std::vector<float> in(static_cast<std::size_t>(std::min(4000.0, 0.5 * rate_Hz)));
      for (std::size_t i = 0; i < in.size(); ++i) {
        in[i] = static_cast<float>(std::sin(2 * M_PI * tone_Hz * (static_cast<double>(i) + 0.5) / rate_Hz));
      }
      const std::vector<float> out = AtDeviceRate(Pcm(in, static_cast<float>(rate_Hz), false).haptic(), 4000);
      ASSERT_NEAR(static_cast<double>(out.size()), 1000.0 * static_cast<double>(in.size()) / rate_Hz, 1.01);
      double in_rms = 0, out_rms = 0;
      for (const float v : in) in_rms += static_cast<double>(v * v) / static_cast<double>(in.size());
      for (const float v : out) out_rms += static_cast<double>(v * v) / static_cast<double>(out.size());
      const double x = M_PI * tone_Hz * 1e-3;
      const double expected = rate_Hz > 1000 ? std::sin(x) / x : 1;
      EXPECT_NEAR(std::sqrt(out_rms / in_rms), expected, 0.06) << rate_Hz << " Hz, tone " << tone_Hz;
    }
  }
}

}  // namespace test_daemon_vibration
}  // namespace omni::daemon
