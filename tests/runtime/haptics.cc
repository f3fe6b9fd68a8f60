// Vibration: recorded per device for tests to read.

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

}  // namespace

XrResult ApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  Session* owner = nullptr;
  Slot* slot = nullptr;
  if (const XrResult check = Find(session, info, &owner, &slot); XR_FAILED(check)) return check;
  OMNI_REQUIRE(Is(haptic, XR_TYPE_HAPTIC_VIBRATION), XR_ERROR_VALIDATION_FAILURE);
  const auto& vibration = *reinterpret_cast<const XrHapticVibration*>(haptic);
  const bool duration_ok = vibration.duration > 0 || vibration.duration == XR_MIN_HAPTIC_DURATION;
  const bool amplitude_ok = vibration.amplitude >= 0 && vibration.amplitude <= 1;
  OMNI_REQUIRE(duration_ok && amplitude_ok && vibration.frequency >= 0, XR_ERROR_VALIDATION_FAILURE);
  if (owner->state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
  OnBoundDevices(state, *slot, [&vibration](HapticRecord& record) {
    ++record.count;
    record.amplitude = vibration.amplitude;
    record.frequency_Hz = vibration.frequency;
    record.duration_ns = vibration.duration;
  });
  return XR_SUCCESS;
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

}  // namespace omni::runtime
