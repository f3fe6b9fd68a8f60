// XrHapticVibration, XR_FB_haptic_amplitude_envelope and XR_FB_haptic_pcm: first what needs no handle of the runtime.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/instance/runtime.h"
#include "layer/src/instance/session.h"
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
  std::uint32_t ReserveSamples(XrAction action, const ShapedVibration& pcm, std::int64_t now_ns, bool& continues);
  // Something else vibrates, or nothing does.
  void Clear();

 private:
  std::mutex mutex_;
  XrAction action_ = XR_NULL_HANDLE;
  std::int64_t end_ns_ = 0;  // when all that was booked has been played
};

// The vibration functions: which device an action vibrates, the pen, the runtime's or both.
class Vibrations {
 public:
  Vibrations(const Runtime& runtime, const Records& records, ServiceLink& link)
      : runtime_(runtime), records_(records), link_(link) {}

  XrResult ApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult StopHapticFeedback(XrSession session, const XrHapticActionInfo* info);
  XrResult GetDeviceSampleRateFB(XrSession session, const XrHapticActionInfo* info, XrDevicePcmSampleRateStateFB* rate);

  void Play(const Pulse& pulse);
  void Stop();

 private:
  struct Channels {
    bool to_pen = false;
    bool unchanged = true;      // to the runtime, as the application called
    std::vector<XrPath> below;  // otherwise: to these subaction paths of the runtime's
    bool to_runtime() const { return unchanged || !below.empty(); }
  };
  Channels Route(XrSession session, const XrHapticActionInfo* info) const;
  XrResult ApplyTone(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult ApplyEnvelope(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult ApplyPcm(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  // Calls the runtime's function `call` for each of its devices. What is not XR_SUCCESS ends it.
  template <class Call>
  static XrResult Below(const Channels& route, const XrHapticActionInfo* info, Call call);
  XrResult ShapeBelow(bool only_ours, XrSession session, const XrHapticActionInfo* info,
                      const XrHapticBaseHeader* haptic, const std::optional<ShapedVibration>& shaped) const;
  std::uint32_t PlayPcm(XrAction action, ShapedVibration& pcm);

  const Runtime& runtime_;
  const Records& records_;
  ServiceLink& link_;
  PcmBacklog backlog_;
};

}  // namespace omni::layer
