// Vibration: recorded per device for tests to read.

#include <algorithm>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

XrResult Find(XrSession session, const XrHapticActionInfo* info, Session** owner, Slot** slot) {
  OMNI_FIND(Session, found, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_HAPTIC_ACTION_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(Action, action, info->action);
  OMNI_REQUIRE(action->type == XR_ACTION_TYPE_VIBRATION_OUTPUT, XR_ERROR_ACTION_TYPE_MISMATCH);
  *owner = found;
  return FindSlot(*found, *action, info->subactionPath, slot);
}

// An inactive (or outranked) action moves nothing.
template <class Act>
void OnBoundDevices(State& state, const Slot& slot, Act act) {
  if (!slot.active) return;
  for (const Bound& bound : slot.bound) {
    if (state.world.IsLive(bound.source)) act(state.world.devices[bound.source.hand].haptics);
  }
}

XrResult Tone(State& state, const Slot& slot, bool focused, const XrHapticBaseHeader* haptic) {
  const auto& vibration = *reinterpret_cast<const XrHapticVibration*>(haptic);
  const bool duration_ok = vibration.duration > 0 || vibration.duration == XR_MIN_HAPTIC_DURATION;
  const bool amplitude_ok = vibration.amplitude >= 0 && vibration.amplitude <= 1;
  OMNI_REQUIRE(duration_ok && amplitude_ok && vibration.frequency >= 0, XR_ERROR_VALIDATION_FAILURE);
  if (!focused) return XR_SESSION_NOT_FOCUSED;
  OnBoundDevices(state, slot, [&vibration](HapticRecord& record) {
    ++record.count;
    record.amplitude = vibration.amplitude;
    record.frequency_Hz = vibration.frequency;
    record.duration_ns = vibration.duration;
  });
  return XR_SUCCESS;
}

XrResult Envelope(State& state, const Slot& slot, bool focused, const XrHapticBaseHeader* haptic) {
  const auto& envelope = *reinterpret_cast<const XrHapticAmplitudeEnvelopeVibrationFB*>(haptic);
  const uint32_t count = envelope.amplitudeCount;
  OMNI_REQUIRE(count > 0 && count <= XR_MAX_HAPTIC_AMPLITUDE_ENVELOPE_SAMPLES_FB && envelope.amplitudes != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(envelope.duration > 0 || envelope.duration == XR_MIN_HAPTIC_DURATION, XR_ERROR_VALIDATION_FAILURE);
  if (!focused) return XR_SESSION_NOT_FOCUSED;
  OnBoundDevices(state, slot, [count](HapticRecord& record) {
    ++record.envelopes;
    record.samples = count;
  });
  return XR_SUCCESS;
}

constexpr uint32_t kSamplesTaken = 1000;  // of one call
constexpr float kSampleRate_Hz = 3000;

XrResult Pcm(State& state, const Slot& slot, bool focused, const XrHapticBaseHeader* haptic) {
  const auto& pcm = *reinterpret_cast<const XrHapticPcmVibrationFB*>(haptic);
  OMNI_REQUIRE(pcm.bufferSize > 0 && pcm.buffer != nullptr && pcm.samplesConsumed != nullptr && pcm.sampleRate > 0,
               XR_ERROR_VALIDATION_FAILURE);
  *pcm.samplesConsumed = 0;
  if (!focused) return XR_SESSION_NOT_FOCUSED;
  const uint32_t taken = std::min(pcm.bufferSize, kSamplesTaken);
  OnBoundDevices(state, slot, [taken](HapticRecord& record) {
    ++record.pcms;
    record.samples = taken;
  });
  *pcm.samplesConsumed = taken;
  return XR_SUCCESS;
}

}  // namespace

XrResult ApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  Session* owner = nullptr;
  Slot* slot = nullptr;
  if (const XrResult check = Find(session, info, &owner, &slot); XR_FAILED(check)) return check;
  OMNI_REQUIRE(haptic != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const bool focused = owner->state == XR_SESSION_STATE_FOCUSED;
  const Instance& instance = *owner->instance;
  if (Is(haptic, XR_TYPE_HAPTIC_VIBRATION)) return Tone(state, *slot, focused, haptic);
  if (Is(haptic, XR_TYPE_HAPTIC_AMPLITUDE_ENVELOPE_VIBRATION_FB) &&
      instance.Enabled(XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME))
    return Envelope(state, *slot, focused, haptic);
  if (Is(haptic, XR_TYPE_HAPTIC_PCM_VIBRATION_FB) && instance.Enabled(XR_FB_HAPTIC_PCM_EXTENSION_NAME))
    return Pcm(state, *slot, focused, haptic);
  return XR_ERROR_VALIDATION_FAILURE;
}

XrResult StopHapticFeedback(XrSession session, const XrHapticActionInfo* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  Session* owner = nullptr;
  Slot* slot = nullptr;
  if (const XrResult check = Find(session, info, &owner, &slot); XR_FAILED(check)) return check;
  if (owner->state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
  OnBoundDevices(state, *slot, [](HapticRecord& record) { ++record.stops; });
  return XR_SUCCESS;
}

XrResult GetDeviceSampleRateFB(XrSession session, const XrHapticActionInfo* info, XrDevicePcmSampleRateStateFB* rate) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  Session* owner = nullptr;
  Slot* slot = nullptr;
  if (const XrResult check = Find(session, info, &owner, &slot); XR_FAILED(check)) return check;
  OMNI_REQUIRE(Is(rate, XR_TYPE_DEVICE_PCM_SAMPLE_RATE_STATE_FB), XR_ERROR_VALIDATION_FAILURE);
  rate->sampleRate = 0;
  OnBoundDevices(state, *slot, [rate](HapticRecord&) { rate->sampleRate = kSampleRate_Hz; });
  return XR_SUCCESS;
}

}  // namespace omni::runtime
