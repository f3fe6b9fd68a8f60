#include "service/daemon/clients/vibration.h"

#include <algorithm>
#include <cmath>

namespace omni::daemon {
namespace {

static_assert(loop::kVibrationRate_Hz == static_cast<double>(protocol::kDeviceSampleRate_Hz));

constexpr auto kBuffer = static_cast<std::uint64_t>(protocol::kWaveformBuffer_s * loop::kVibrationRate_Hz);
// A client schedules its samples a little before they arrive here, and the tick starts them a little later.
constexpr std::uint64_t kLate = 500;
constexpr std::uint64_t kStillPlaying = 100;
static_assert(kBuffer + kLate + kStillPlaying <= loop::kMaxVibrationSamples);
static_assert(protocol::kMaxWaveformSamples <= loop::kMaxVibrationSamples);

double Seconds(std::int64_t duration_ns) { return duration_ns < 0 ? -1.0 : static_cast<double>(duration_ns) * 1e-9; }

std::vector<float> Floats(const protocol::ShapedHaptic& haptic) {
  std::vector<float> values(haptic.waveform.count);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = haptic.sample(i);
  return values;
}

}  // namespace

std::vector<float> AtDeviceRate(const protocol::ShapedHaptic& pcm, std::size_t most) {
  const std::vector<float> in = Floats(pcm);
  const double step = static_cast<double>(pcm.waveform.sample_rate_Hz) / loop::kVibrationRate_Hz;
  const double count = std::ceil(static_cast<double>(in.size()) / step - 1e-6);
  std::vector<float> out(static_cast<std::size_t>(std::clamp(count, 1.0, static_cast<double>(most))));
  for (std::size_t k = 0; k < out.size(); ++k) {
    const auto from = static_cast<double>(k);
    out[k] = static_cast<float>(loop::MeanBetween(in, from * step, (from + 1) * step));
  }
  return out;
}

void Vibration::Start(loop::VibrationKind kind, double duration_s) {
  waveform_ = {.id = waveform_.id + 1, .active = true, .kind = kind, .duration_s = duration_s};
}

void Vibration::PlayTone(const protocol::Haptic& haptic) {
  Start(loop::VibrationKind::kTone, Seconds(haptic.duration_ns));
  waveform_.amplitude = static_cast<double>(haptic.amplitude);
  waveform_.frequency_Hz = static_cast<double>(haptic.frequency_Hz);
}

void Vibration::PlayShaped(const protocol::ShapedHaptic& haptic, std::int64_t now_ns) {
  fresh_ = true;
  if (haptic.waveform.kind == protocol::WaveformKind::kPcm) return Append(haptic, now_ns);
  Start(loop::VibrationKind::kEnvelope, Seconds(haptic.waveform.duration_ns));
  const std::vector<float> values = Floats(haptic);
  samples_.id = waveform_.id;
  samples_.first = 0;
  samples_.count = static_cast<std::uint32_t>(values.size());
  std::copy(values.begin(), values.end(), samples_.values.begin());
}

bool Vibration::PcmIsPlaying(std::int64_t now_ns) const {
  const auto length_ns = static_cast<std::int64_t>(samples_.first + samples_.count) * 1'000'000;
  return waveform_.active && waveform_.kind == loop::VibrationKind::kPcm && now_ns < pcm_start_ns_ + length_ns;
}

void Vibration::DropPlayed(std::int64_t now_ns) {
  const auto played = static_cast<std::uint64_t>(std::max<std::int64_t>(0, (now_ns - pcm_start_ns_) / 1'000'000));
  const std::uint64_t keep_from = played > kStillPlaying ? played - kStillPlaying : 0;
  if (keep_from <= samples_.first) return;
  const auto drop = static_cast<std::uint32_t>(std::min<std::uint64_t>(keep_from - samples_.first, samples_.count));
  std::copy(samples_.values.begin() + drop, samples_.values.begin() + samples_.count, samples_.values.begin());
  samples_.first += drop;
  samples_.count -= drop;
}

void Vibration::Append(const protocol::ShapedHaptic& haptic, std::int64_t now_ns) {
  if (haptic.waveform.append == 0 || !PcmIsPlaying(now_ns)) {
    Start(loop::VibrationKind::kPcm, 0);
    samples_.id = waveform_.id;
    samples_.first = 0;
    samples_.count = 0;
    pcm_start_ns_ = now_ns;
  }
  DropPlayed(now_ns);
  const std::uint32_t room = loop::kMaxVibrationSamples - samples_.count;
  if (room == 0) return;
  const std::vector<float> values = AtDeviceRate(haptic, room);
  std::copy(values.begin(), values.end(), samples_.values.begin() + samples_.count);
  samples_.count += static_cast<std::uint32_t>(values.size());
}

bool Vibration::PopFresh() {
  const bool fresh = fresh_;
  fresh_ = false;
  return fresh;
}

}  // namespace omni::daemon
