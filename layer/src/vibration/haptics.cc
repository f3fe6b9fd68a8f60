#include "layer/src/vibration/haptics.h"

#include <algorithm>
#include <cmath>

namespace omni::layer {
namespace {

bool AllFinite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

// `count` values as at most `most`: each the mean of its share.
std::vector<float> Shrunk(const float* values, std::size_t count, std::size_t most) {
  const std::size_t size = std::min(count, most);
  std::vector<float> out(size);
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t from = i * count / size, to = (i + 1) * count / size;
    double sum = 0;
    for (std::size_t k = from; k < to; ++k) sum += static_cast<double>(values[k]);
    out[i] = static_cast<float>(sum / static_cast<double>(to - from));
  }
  return out;
}

}  // namespace

std::optional<ShapedVibration> ReadEnvelope(const XrHapticAmplitudeEnvelopeVibrationFB& envelope) {
  const bool valid = envelope.amplitudeCount > 0 && envelope.amplitudes &&
                     envelope.duration >= XR_MIN_HAPTIC_DURATION &&
                     AllFinite(envelope.amplitudes, envelope.amplitudeCount);
  if (!valid) return std::nullopt;
  ShapedVibration out;
  out.waveform.kind = protocol::WaveformKind::kEnvelope;
  out.waveform.duration_ns = envelope.duration;
  out.samples = Shrunk(envelope.amplitudes, envelope.amplitudeCount, protocol::kMaxWaveformSamples);
  return out;
}

std::optional<ShapedVibration> ReadPcm(const XrHapticPcmVibrationFB& pcm) {
  const bool rate_ok = pcm.sampleRate > 0 && pcm.sampleRate <= protocol::kHighestSampleRate_Hz;
  const bool valid = pcm.bufferSize > 0 && pcm.buffer && pcm.samplesConsumed && rate_ok;
  if (!valid) return std::nullopt;
  const std::size_t count = std::min(pcm.bufferSize, protocol::kMaxWaveformSamples);
  if (!AllFinite(pcm.buffer, count)) return std::nullopt;
  ShapedVibration out;
  out.waveform.kind = protocol::WaveformKind::kPcm;
  out.waveform.sample_rate_Hz = pcm.sampleRate;
  out.waveform.append = pcm.append == XR_TRUE ? 1 : 0;
  out.samples.assign(pcm.buffer, pcm.buffer + count);
  return out;
}

XrHapticVibration WithoutShape(const ShapedVibration& shaped) {
  const bool envelope = shaped.waveform.kind == protocol::WaveformKind::kEnvelope;
  double sum = 0;
  for (const float sample : shaped.samples) {
    const double x = std::clamp(static_cast<double>(sample), envelope ? 0.0 : -1.0, 1.0);
    sum += envelope ? x : x * x;
  }
  const auto count = static_cast<double>(shaped.samples.size());
  double amplitude = envelope ? sum / count : std::min(1.0, std::sqrt(2 * sum / count));
  const double length_ns = envelope ? 0 : 1e9 * count / static_cast<double>(shaped.waveform.sample_rate_Hz);
  return {XR_TYPE_HAPTIC_VIBRATION, nullptr,
          envelope ? shaped.waveform.duration_ns : std::max<XrDuration>(1, static_cast<XrDuration>(length_ns)),
          XR_FREQUENCY_UNSPECIFIED, static_cast<float>(amplitude)};
}

std::uint32_t PcmBacklog::Book(XrAction action, const ShapedVibration& pcm, std::int64_t now_ns, bool& continues) {
  const std::lock_guard lock(mutex_);
  continues = pcm.waveform.append == 1 && action == action_ && end_ns_ > now_ns;
  const std::int64_t begin_ns = continues ? end_ns_ : now_ns;
  const double rate_Hz = static_cast<double>(pcm.waveform.sample_rate_Hz);
  const double room_s = protocol::kWaveformBuffer_s - 1e-9 * static_cast<double>(begin_ns - now_ns);
  const double room = std::max(0.0, std::floor(room_s * rate_Hz));
  const auto taken = static_cast<std::uint32_t>(std::min(room, static_cast<double>(pcm.samples.size())));
  action_ = action;
  end_ns_ = begin_ns + static_cast<std::int64_t>(1e9 * taken / rate_Hz);
  return taken;
}

void PcmBacklog::Clear() {
  const std::lock_guard lock(mutex_);
  action_ = XR_NULL_HANDLE;
  end_ns_ = 0;
}

}  // namespace omni::layer
