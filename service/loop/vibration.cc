#include "service/loop/vibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::loop {
namespace {

double Sane(float value) noexcept { return value >= -1.0F && value <= 1.0F ? static_cast<double>(value) : 0.0; }

double Wave(double frequency_Hz, double time_s) noexcept {
  return std::sin(2 * std::numbers::pi * frequency_Hz * time_s);
}

double Duration_s(const VibrationConfig& config, const HapticWaveform& waveform) noexcept {
  return waveform.duration_s < 0 ? config.shortest_s : waveform.duration_s;
}

double Tone(const VibrationConfig& config, const HapticWaveform& waveform, double dt_s,
            VibrationState& state) noexcept {
  if (!(state.time_s < Duration_s(config, waveform))) state.playing = false;
  if (!state.playing) return 0;
  state.time_s += dt_s;
  const double frequency_Hz = waveform.frequency_Hz > 0 ? waveform.frequency_Hz : config.best_Hz;
  return std::clamp(waveform.amplitude, 0.0, 1.0) * Wave(frequency_Hz, state.time_s);
}

double Envelope(const VibrationConfig& config, const HapticWaveform& waveform, const VibrationSamples& samples,
                double dt_s, VibrationState& state) noexcept {
  const double duration_s = Duration_s(config, waveform);
  if (!(state.time_s < duration_s)) state.playing = false;
  if (!state.playing) return 0;
  const double samples_s = samples.count / duration_s;
  const double from_s = state.time_s;
  state.time_s += dt_s;
  const double end_s = std::min(state.time_s, duration_s);
  const double amplitude = MeanBetween({samples.values.data(), samples.count}, from_s * samples_s, end_s * samples_s);
  return std::clamp(amplitude, 0.0, 1.0) * Wave(config.best_Hz, state.time_s);
}

double Pcm(const VibrationSamples& samples, double dt_s, VibrationState& state) noexcept {
  const auto at = static_cast<std::uint64_t>(std::llround(std::clamp(state.time_s, 0.0, 1e9) * kVibrationRate_Hz));
  if (at >= samples.first + samples.count) return 0;  // time stands still until more samples come
  state.time_s += dt_s;
  return at < samples.first ? 0 : Sane(samples.values[at - samples.first]);
}

// -1..1 of the largest force, if the request is sane.
double Play(const VibrationConfig& config, const HapticWaveform& waveform, const VibrationSamples* samples, double dt_s,
            VibrationState& state) noexcept {
  if (waveform.kind == VibrationKind::kTone) return Tone(config, waveform, dt_s, state);
  if (samples == nullptr || samples->id != waveform.id || samples->count > kMaxVibrationSamples) return 0;
  if (waveform.kind == VibrationKind::kPcm) return Pcm(*samples, dt_s, state);
  return Envelope(config, waveform, *samples, dt_s, state);
}

}  // namespace

double MeanBetween(std::span<const float> samples, double from, double to) noexcept {
  if (!(to > from && from >= 0 && from < static_cast<double>(samples.size()))) return 0;
  const double end = std::min(to, static_cast<double>(samples.size()));
  double sum = 0;
  for (auto i = static_cast<std::size_t>(from); i < samples.size() && static_cast<double>(i) < end; ++i) {
    const auto low = static_cast<double>(i);
    sum += Sane(samples[i]) * (std::min(end, low + 1) - std::max(from, low));
  }
  return sum / (end - from);
}

double VibrationForce_N(const VibrationConfig& config, const HapticWaveform& waveform, const VibrationSamples* samples,
                        double dt_s, VibrationState& state) noexcept {
  if (waveform.id != state.id) state = {.id = waveform.id, .playing = waveform.active};
  if (!waveform.active) state.playing = false;
  if (!state.playing) return 0;
  const double share = Play(config, waveform, samples, dt_s, state);
  return std::isfinite(share) ? config.force_N * share : 0;
}

}  // namespace omni::loop
