// Reading input and writing haptics. The next layer is always asked first: it validates, and its answer stands
// wherever the pen has no part.
#include <algorithm>
#include <cstring>

#include "layer/src/fault.h"
#include "layer/src/instance.h"

namespace omni::layer {
namespace {

// Fills `state` with what the last sync found, if the pen has had a part in this session.
template <class State, class Assign>
void Overlay(const Instance& instance, XrSession session, const XrActionStateGetInfo& info, State& state,
             Assign assign) {
  const auto record = instance.sessions.Find(session);
  const auto action = record ? instance.actions.Find(info.action) : nullptr;
  if (!action) return;
  const std::shared_lock lock(record->mutex);
  const ActionState* merged = record->actions.Find(*action, info.subactionPath);
  if (!merged) return;
  state.isActive = merged->active ? XR_TRUE : XR_FALSE;
  assign(*merged, state);
}

template <class State>
void AssignTimes(const ActionState& merged, State& state) {
  state.changedSinceLastSync = merged.changed || OMNI_FAULT("changed-always") ? XR_TRUE : XR_FALSE;
  state.lastChangeTime = merged.last_change;
}

}  // namespace

XrResult Instance::GetBoolean(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* state) {
  const XrResult result = next.GetActionStateBoolean(session, info, state);
  link.Beat();
  if (XR_FAILED(result)) return OMNI_FAULT("query-error-swallowed") ? XR_SUCCESS : result;
  Overlay(*this, session, *info, *state, [](const ActionState& merged, XrActionStateBoolean& out) {
    out.currentState = merged.value.x > kPressThreshold ? XR_TRUE : XR_FALSE;
    AssignTimes(merged, out);
  });
  return result;
}

XrResult Instance::GetFloat(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* state) {
  const XrResult result = next.GetActionStateFloat(session, info, state);
  link.Beat();
  if (XR_FAILED(result)) return result;
  Overlay(*this, session, *info, *state, [&](const ActionState& merged, XrActionStateFloat& out) {
    out.currentState = merged.value.x;
    if (OMNI_FAULT("states-not-snapshotted"))
      out.currentState = link.Read(MonotonicNow_ns()).inputs.components[0].value;
    AssignTimes(merged, out);
  });
  return result;
}

XrResult Instance::GetVector2f(XrSession session, const XrActionStateGetInfo* info, XrActionStateVector2f* state) {
  const XrResult result = next.GetActionStateVector2f(session, info, state);
  link.Beat();
  if (XR_FAILED(result)) return result;
  Overlay(*this, session, *info, *state, [](const ActionState& merged, XrActionStateVector2f& out) {
    out.currentState = merged.value;
    AssignTimes(merged, out);
  });
  return result;
}

XrResult Instance::GetPose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* state) {
  const XrResult result = next.GetActionStatePose(session, info, state);
  link.Beat();
  if (XR_FAILED(result)) return result;
  Overlay(*this, session, *info, *state, [](const ActionState&, XrActionStatePose&) {});
  return result;
}

// Any doubt about the arguments leaves the call to the runtime, which knows the right error.
Instance::HapticRoute Instance::RouteHaptic(XrSession session, const XrHapticActionInfo* info) const {
  if (!info || info->type != XR_TYPE_HAPTIC_ACTION_INFO) return {};
  const auto record = sessions.Find(session);
  const auto action = record ? actions.Find(info->action) : nullptr;
  if (!action || action->type != XR_ACTION_TYPE_VIBRATION_OUTPUT) return {};
  if (!record->focused && !OMNI_FAULT("haptic-without-focus")) return {};
  const std::shared_lock lock(record->mutex);
  const SessionActions& state = record->actions;
  if (!state.attached(*action->set) || !state.pen_owns_hand()) return {};
  const bool our_hand = info->subactionPath == state.hand_path() && action->Declares(state.hand_path());
  return {state.HapticBound(*action, info->subactionPath), !our_hand && !OMNI_FAULT("haptic-to-pen-only")};
}

XrResult Instance::ApplyHaptic(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  Alive();
  if (!haptic || haptic->type != XR_TYPE_HAPTIC_VIBRATION) return next.ApplyHapticFeedback(session, info, haptic);
  const HapticRoute route = RouteHaptic(session, info);
  const XrResult result = route.to_runtime ? next.ApplyHapticFeedback(session, info, haptic) : XR_SUCCESS;
  if (!route.to_pen || result != XR_SUCCESS) return result;
  XrHapticVibration v;
  std::memcpy(&v, haptic, sizeof(v));
  // XR_MIN_HAPTIC_DURATION is -1, as in the protocol. NaN fails the comparison and becomes rest.
  const float amplitude = v.amplitude >= 0 ? std::min(v.amplitude, 1.0f) : 0.0f;
  const float frequency_Hz = v.frequency >= 0 ? v.frequency : 0.0f;
  link.Haptic(std::max<XrDuration>(v.duration, XR_MIN_HAPTIC_DURATION), amplitude, frequency_Hz);
  return result;
}

XrResult Instance::StopHaptic(XrSession session, const XrHapticActionInfo* info) {
  Alive();
  const HapticRoute route = RouteHaptic(session, info);
  const XrResult result = route.to_runtime ? next.StopHapticFeedback(session, info) : XR_SUCCESS;
  if (route.to_pen && result == XR_SUCCESS && !OMNI_FAULT("haptic-stop-dropped")) link.HapticStop();
  return result;
}

}  // namespace omni::layer
