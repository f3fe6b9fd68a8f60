// Vibrations with a shape: an amplitude envelope, or PCM samples of the force itself. Plain data, std only.
// Message types 14 to 19. The samples follow the struct in the same packet; Validate refuses what is out of range.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "service/protocol/control.h"

namespace omni::protocol {

// XR_MAX_HAPTIC_PCM_BUFFER_SIZE_FB and XR_MAX_HAPTIC_AMPLITUDE_ENVELOPE_SAMPLES_FB.
inline constexpr std::uint32_t kMaxWaveformSamples = 4000;
inline constexpr float kHighestSampleRate_Hz = 1e5f;
// Samples per second for the coils: one per tick. PCM at this rate is played as it is.
inline constexpr float kDeviceSampleRate_Hz = 1000;
// How much unplayed PCM omnid keeps: further samples are dropped, so a client does not send them.
inline constexpr double kWaveformBuffer_s = 4.0;

enum class WaveformKind : std::uint32_t {
  kEnvelope = 1,  // amplitudes 0..1 of the device's best frequency, spread evenly over duration_ns
  kPcm = 2        // -1..1 of the largest vibration force, sample_rate_Hz of them per second
};

// Replaces what vibrates, except kPcm with append.
struct Waveform {
  MessageHeader header{.type = MessageType::kWaveform, .size = sizeof(Waveform)};
  WaveformKind kind = WaveformKind::kEnvelope;
  std::uint32_t count = 0;       // floats behind this: 1 to kMaxWaveformSamples
  std::int64_t duration_ns = 0;  // kEnvelope: -1 is the shortest; kPcm: 0
  float sample_rate_Hz = 0;      // kPcm: above 0; kEnvelope: 0
  std::uint32_t append = 0;      // kPcm: 1: played after PCM that is still playing
};
static_assert(std::is_trivially_copyable_v<Waveform> && sizeof(Waveform) == 40);
static_assert(sizeof(Waveform) + sizeof(float) * kMaxWaveformSamples <= kMaxMessageBytes);

// A Waveform with the samples behind it, a view into the validated bytes: finite and in range.
struct ShapedHaptic {
  Waveform waveform;
  std::string_view bytes;
  float sample(std::size_t i) const noexcept {
    float value = 0;
    std::memcpy(&value, bytes.data() + i * sizeof(value), sizeof(value));
    return value;
  }
};

}  // namespace omni::protocol
