// The vibration that the owner of the force has requested, in the form that the tick uses. Control thread only.
#pragma once

#include <cstdint>
#include <vector>

#include "service/loop/vibration.h"
#include "service/protocol/control.h"
#include "service/protocol/waveform.h"

namespace omni::daemon {

class Vibration {
 public:
  // Each, except appended PCM, replaces the one before.
  void PlayTone(const protocol::Haptic& haptic);
  void PlayShaped(const protocol::ShapedHaptic& haptic, std::int64_t now_ns);
  void Stop() { waveform_.active = false; }

  const loop::HapticWaveform& waveform() const { return waveform_; }
  const loop::VibrationSamples& samples() const { return samples_; }
  // True: samples() has changed since the last call.
  bool PopFresh();

 private:
  void Start(loop::VibrationKind kind, double duration_s);
  void Append(const protocol::ShapedHaptic& haptic, std::int64_t now_ns);
  bool PcmIsPlaying(std::int64_t now_ns) const;
  void DropPlayed(std::int64_t now_ns);

  loop::HapticWaveform waveform_;
  loop::VibrationSamples samples_;
  std::int64_t pcm_start_ns_ = 0;
  bool fresh_ = false;
};

// PCM at the rate of the coils: each result is the mean of its millisecond. At most `most` of them.
std::vector<float> AtDeviceRate(const protocol::ShapedHaptic& pcm, std::size_t most);

}  // namespace omni::daemon
