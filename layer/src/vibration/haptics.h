// Vibrations: XrHapticVibration, XR_FB_haptic_amplitude_envelope and XR_FB_haptic_pcm. Instance has the calls; here is
// what needs no handle of the runtime.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"
#include "service/protocol/waveform.h"

namespace omni::layer {

// A vibration with a shape, as the service wants it.
struct ShapedVibration {
  protocol::Waveform waveform;
  std::vector<float> samples;
};

// [XR_FB_haptic_amplitude_envelope] Empty: the structure is invalid. More amplitudes than fit are averaged down.
std::optional<ShapedVibration> ReadEnvelope(const XrHapticAmplitudeEnvelopeVibrationFB& envelope);

// [XR_FB_haptic_pcm] At most as many samples as fit into one message. Empty: the structure is invalid.
std::optional<ShapedVibration> ReadPcm(const XrHapticPcmVibrationFB& pcm);

// The closest vibration without a shape, for devices that play no other: of the same length; an envelope's
// mean amplitude, or the amplitude of a sine with the power of the PCM.
XrHapticVibration WithoutShape(const ShapedVibration& shaped);

// How much PCM was sent to the service and is not played yet: it keeps protocol::kWaveformBuffer_s of it. Any
// thread.
class PcmBacklog {
 public:
  // Books as many of the samples as fit now, and says how many. They follow the previous ones if the application
  // appends and its last PCM was for this action and still plays; otherwise they replace them: `continues` says which.
  std::uint32_t Book(XrAction action, const ShapedVibration& pcm, std::int64_t now_ns, bool& continues);
  // Something else vibrates, or nothing does.
  void Clear();

 private:
  std::mutex mutex_;
  XrAction action_ = XR_NULL_HANDLE;
  std::int64_t end_ns_ = 0;  // when all that was booked has been played
};

}  // namespace omni::layer
