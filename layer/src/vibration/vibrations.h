// The vibration functions: which device an action vibrates, the pen, the runtime's or both.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "layer/src/instance/runtime.h"
#include "layer/src/instance/session.h"
#include "layer/src/vibration/haptics.h"

namespace omni::layer {

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
