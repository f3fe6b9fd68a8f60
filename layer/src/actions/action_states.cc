// Reading input. The next layer is always called first: it validates, and its answer is returned unless the pen
// contributes.
#include "layer/src/actions/input.h"
#include "service/base/clock.h"

namespace omni::layer {
namespace {

// Fills `state` with what the last sync found, if the pen has contributed in this session.
template <class State, class Assign>
void Overlay(const Records& records, XrSession session, const XrActionStateGetInfo& info, State& state, Assign assign) {
  const auto record = records.sessions.Find(session);
  const auto action = record ? records.actions.Find(info.action) : nullptr;
  if (!action) return;
  const std::shared_lock lock(record->mutex);
  const ActionState* merged = record->actions.FindState(*action, info.subactionPath);
  if (!merged) return;
  state.isActive = merged->active ? XR_TRUE : XR_FALSE;
  assign(*merged, state);
}

template <class State>
void AssignTimes(const ActionState& merged, State& state) {
  state.changedSinceLastSync = merged.changed ? XR_TRUE : XR_FALSE;
  state.lastChangeTime = merged.last_change;
}

}  // namespace

XrResult Input::GetActionStateBoolean(XrSession session, const XrActionStateGetInfo* info,
                                      XrActionStateBoolean* state) {
  const XrResult result = runtime_.next.GetActionStateBoolean(session, info, state);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  Overlay(records_, session, *info, *state, [](const ActionState& merged, XrActionStateBoolean& out) {
    out.currentState = merged.value.x > kPressThreshold ? XR_TRUE : XR_FALSE;
    AssignTimes(merged, out);
  });
  return result;
}

XrResult Input::GetActionStateFloat(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* state) {
  const XrResult result = runtime_.next.GetActionStateFloat(session, info, state);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  Overlay(records_, session, *info, *state, [&](const ActionState& merged, XrActionStateFloat& out) {
    out.currentState = merged.value.x;
    AssignTimes(merged, out);
  });
  return result;
}

XrResult Input::GetActionStateVector2f(XrSession session, const XrActionStateGetInfo* info,
                                       XrActionStateVector2f* state) {
  const XrResult result = runtime_.next.GetActionStateVector2f(session, info, state);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  Overlay(records_, session, *info, *state, [](const ActionState& merged, XrActionStateVector2f& out) {
    out.currentState = merged.value;
    AssignTimes(merged, out);
  });
  return result;
}

XrResult Input::GetActionStatePose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* state) {
  const XrResult result = runtime_.next.GetActionStatePose(session, info, state);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  Overlay(records_, session, *info, *state, [](const ActionState&, XrActionStatePose&) {});
  return result;
}

}  // namespace omni::layer
