// Vibrations that an application requests, as a force along the pen's axis: a tone, a tone under an envelope, or PCM.
// The coils receive one force per tick, so 1 kHz is their sample rate; bandwidth: docs/theory/haptics.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

namespace omni::loop {

struct VibrationConfig {
  double force_N = 0.25;      // amplitude 1
  double shortest_s = 0.020;  // XR_MIN_HAPTIC_DURATION
  double best_Hz = 80;        // XR_FREQUENCY_UNSPECIFIED, and the tone under an envelope
};

enum class VibrationKind : std::uint8_t {
  kTone = 0,
  kEnvelope = 1,  // samples 0..1, spread evenly over duration_s
  kPcm = 2        // samples -1..1, one per millisecond; more may be appended while it plays
};

// What the owner requests. A new id starts it; the same id continues it; active = false stops it.
struct HapticWaveform {
  std::uint64_t id = 0;
  bool active = false;
  VibrationKind kind = VibrationKind::kTone;
  double duration_s = 0;    // < 0: shortest; kPcm: as long as there are samples
  double amplitude = 0;     // 0..1; kTone
  double frequency_Hz = 0;  // 0: best; kTone
};

inline constexpr double kVibrationRate_Hz = 1000;
inline constexpr std::uint32_t kMaxVibrationSamples = 4608;  // the caller ensures that samples fit

// Samples of the waveform with this id.
struct VibrationSamples {
  std::uint64_t id = 0;
  std::uint64_t first = 0;  // kPcm: how many came before values[0] and were played
  std::uint32_t count = 0;
  std::array<float, kMaxVibrationSamples> values{};
};
static_assert(std::is_trivially_copyable_v<HapticWaveform> && std::is_trivially_copyable_v<VibrationSamples>);

struct VibrationState {
  std::uint64_t id = 0;  // last waveform taken up
  double time_s = 0;     // since it started
  bool playing = false;
  bool counted = false;  // it has reached the coil command
};
static_assert(std::is_trivially_copyable_v<VibrationState>);

// Mean of a staircase, sample i over [i, i + 1), between two places of it; outside it is 0. Samples beyond -1..1, or
// NaN, count as 0.
double MeanBetween(std::span<const float> samples, double from, double to) noexcept;

// Force of this tick along the pen's axis, within +-force_N. `samples` may be null or those of another waveform: then a
// waveform that needs them waits. PCM that has no further samples waits as well.
double VibrationForce_N(const VibrationConfig& config, const HapticWaveform& waveform, const VibrationSamples* samples,
                        double dt_s, VibrationState& state) noexcept;

}  // namespace omni::loop
