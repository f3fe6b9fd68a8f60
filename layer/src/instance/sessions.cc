// Sessions and events: when the pen has an application to serve, and which.
#include <cstring>

#include "layer/src/instance/instance.h"
#include "service/base/clock.h"

namespace omni::layer {

XrResult Instance::CreateSession(const XrSessionCreateInfo* info, XrSession* session) {
  const XrResult result = runtime.next.CreateSession(runtime.handle, info, session);
  KeepAlive();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<Session>(*session, profiles, link.choice(), runtime.hand_paths);
  locator.MakeAnchors(*record);
  alignment.RequestBasePose(*record, info->systemId);
  records.sessions.Insert(*session, std::move(record));
  return result;
}

XrResult Instance::DestroySession(XrSession session) {
  const XrResult result = runtime.next.DestroySession(session);
  if (XR_FAILED(result)) return result;
  force_feedbacks.EndOf(session);
  haptic_scenes.EndOf(session);
  render_models.EndOf(session);
  locator.EndOf(session);
  if (const auto record = records.sessions.Find(session)) {
    record->running = false;
    SetFocus(*record, false);
  }
  records.sessions.Erase(session);
  ReportSessionState();
  return result;
}

XrResult Instance::BeginSession(XrSession session, const XrSessionBeginInfo* info) {
  const XrResult result = runtime.next.BeginSession(session, info);
  KeepAlive();
  if (XR_FAILED(result)) return result;
  if (const auto record = records.sessions.Find(session)) {
    record->running = true;
  }
  ReportSessionState();
  return result;
}

XrResult Instance::EndSession(XrSession session) {
  const XrResult result = runtime.next.EndSession(session);
  KeepAlive();
  if (XR_FAILED(result)) return result;
  if (const auto record = records.sessions.Find(session)) {
    SetFocus(*record, false);
    record->running = false;
    record->profile_event_due = false;
  }
  ReportSessionState();
  return result;
}

// Losing focus ends vibrations and forces.
void Instance::SetFocus(Session& session, bool focused) {
  if (session.focused.exchange(focused) == focused) return;
  if (!focused) {
    session.focus_was_lost = true;
    vibrations.Stop();
    force_feedbacks.OnFocusLost(session);
  }
  ReportSessionState();
}

// A runtime that dies sends no event: forces and vibrations end with the first call that says so.
void Instance::OnLoss() {
  for (const auto& session : records.sessions.Values()) SetFocus(*session, false);
}

void Instance::ReportSessionState() {
  protocol::SessionState state = protocol::SessionState::kNone;
  records.sessions.ForEach([&](const Session& session) {
    if (!session.running) return;
    const bool felt = session.focused && !session.user_away;
    state = std::max(state, felt ? protocol::SessionState::kFocused : protocol::SessionState::kBegun);
  });
  link.SetSession(state);
}

// A headset that is taken off ends forces and vibrations as a lost focus does, but for the application nothing changes.
void Instance::OnUserPresence(const XrEventDataUserPresenceChangedEXT& changed) {
  const auto session = records.sessions.Find(changed.session);
  if (!session) return;
  session->user_away = changed.isUserPresent == XR_FALSE;
  if (session->user_away) vibrations.Stop();
  ReportSessionState();
}

XrResult Instance::PollBelow(XrEventDataBuffer* event) {
  const void* const chain = event ? event->next : nullptr;
  for (;;) {
    const XrResult result = runtime.next.PollEvent(runtime.handle, event);
    if (result != XR_SUCCESS || !event || event->type != XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT) return result;
    XrEventDataUserPresenceChangedEXT changed;
    std::memcpy(&changed, event, sizeof(changed));
    OnUserPresence(changed);
    if (!hide_presence) return result;
    event->type = XR_TYPE_EVENT_DATA_BUFFER;
    event->next = chain;
  }
}

XrResult Instance::PollEvent(XrEventDataBuffer* event) {
  const XrResult result = PollBelow(event);
  KeepAlive();
  haptic_scenes.Poll();
  if (result == XR_SUCCESS && event) {
    if (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
      XrEventDataSessionStateChanged changed;
      std::memcpy(&changed, event, sizeof(changed));
      if (const auto session = records.sessions.Find(changed.session))
        SetFocus(*session, changed.state == XR_SESSION_STATE_FOCUSED);
    } else if (event->type == XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED) {
      // One event says that any profile of the session may have changed: ours is delivered with it.
      XrEventDataInteractionProfileChanged changed;
      std::memcpy(&changed, event, sizeof(changed));
      const auto session = records.sessions.Find(changed.session);
      if (session) session->profile_event_due = false;
    } else if (event->type == XR_TYPE_EVENT_DATA_INTERACTION_RENDER_MODELS_CHANGED_EXT) {
      render_models.PopChange();
    } else if (event->type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) {
      XrEventDataReferenceSpaceChangePending changed;
      std::memcpy(&changed, event, sizeof(changed));
      alignment.OnSpaceChange(changed);
    }
    return result;
  }
  if (result != XR_EVENT_UNAVAILABLE || !event) return result;
  force_feedbacks.QueueStateEvents();
  XrSession due = XR_NULL_HANDLE;
  records.sessions.ForEach([&](Session& session) {
    if (due == XR_NULL_HANDLE && session.running && session.profile_event_due.exchange(false)) due = session.handle;
  });
  if (due == XR_NULL_HANDLE && render_models.PopChange()) {
    const XrEventDataInteractionRenderModelsChangedEXT changed{XR_TYPE_EVENT_DATA_INTERACTION_RENDER_MODELS_CHANGED_EXT,
                                                               nullptr};
    std::memcpy(event, &changed, sizeof(changed));
    return XR_SUCCESS;
  }
  if (due == XR_NULL_HANDLE) {
    XrEventDataBuffer ours;
    do {
      if (!events.Pop(ours)) return result;
    } while (force_feedbacks.IsOfDestroyed(ours) || haptic_scenes.IsOfDestroyed(ours));
    *event = ours;
    return XR_SUCCESS;
  }
  const XrEventDataInteractionProfileChanged changed{XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, nullptr, due};
  std::memcpy(event, &changed, sizeof(changed));
  return XR_SUCCESS;
}

XrResult Instance::SyncActions(XrSession session, const XrActionsSyncInfo* info) {
  const XrResult result = runtime.next.SyncActions(session, info);
  KeepAlive();
  const auto record = records.sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  const std::int64_t now = base::MonotonicNow_ns();
  clock.Refresh(now);
  const bool focused = result != XR_SESSION_NOT_FOCUSED;
  if (record->running) SetFocus(*record, focused);
  force_feedbacks.FollowConstraints();
  force_feedbacks.QueueStateEvents();
  input.Sync(*record, *info, focused, now);
  render_models.UpdateAfterSync(record);
  return result;
}

XrResult Instance::DestroySpace(XrSpace space) {
  const XrResult result = runtime.next.DestroySpace(space);
  link.SignalAlive();
  if (XR_SUCCEEDED(result)) {
    force_feedbacks.ForgetSpace(space);
    haptic_scenes.ForgetSpace(space);
    records.spaces.Erase(space);
  }
  return result;
}

XrResult Instance::WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state) {
  const XrResult result = runtime.next.WaitFrame(session, info, state);
  const std::int64_t now = base::MonotonicNow_ns();
  KeepAlive();
  clock.Refresh(now);
  if (XR_SUCCEEDED(result) && state) {
    clock.OnFrame(*state, now);
    haptic_scenes.FollowSpace(session, state->predictedDisplayTime);
  }
  force_feedbacks.FollowConstraints();
  force_feedbacks.QueueStateEvents();
  return result;
}

}  // namespace omni::layer
