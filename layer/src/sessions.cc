// Sessions and events: when the pen has an application to serve, and which.
#include <cstring>

#include "layer/src/instance.h"

namespace omni::layer {

XrResult Instance::CreateSession(const XrSessionCreateInfo* info, XrSession* session) {
  const XrResult result = next.CreateSession(handle, info, session);
  Alive();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<Session>(*session, profiles, hand, hand_path);
  XrReferenceSpaceCreateInfo anchor{
      XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, 0}}};
  if (XR_FAILED(next.CreateReferenceSpace(*session, &anchor, &record->anchor))) {
    record->anchor = XR_NULL_HANDLE;
    log.Line("the runtime gives no LOCAL space: the pen's pose stays invalid in this session");
  }
  sessions.Insert(*session, std::move(record));
  return result;
}

XrResult Instance::DestroySession(XrSession session) {
  const XrResult result = next.DestroySession(session);
  if (XR_FAILED(result)) return result;
  spaces.EraseIf([session](const Space& space) { return space.session && space.session->handle == session; });
  if (const auto record = sessions.Find(session)) {
    record->running = false;
    SetFocus(*record, false);
  }
  sessions.Erase(session);
  ReportSessionState();
  return result;
}

XrResult Instance::BeginSession(XrSession session, const XrSessionBeginInfo* info) {
  const XrResult result = next.BeginSession(session, info);
  Alive();
  if (XR_FAILED(result)) return result;
  if (const auto record = sessions.Find(session)) record->running = true;
  ReportSessionState();
  return result;
}

XrResult Instance::EndSession(XrSession session) {
  const XrResult result = next.EndSession(session);
  Alive();
  if (XR_FAILED(result)) return result;
  if (const auto record = sessions.Find(session)) {
    SetFocus(*record, false);
    record->running = false;
    record->profile_event_due = false;
  }
  ReportSessionState();
  return result;
}

// Leaving focus ends what vibrates and takes the force away.
void Instance::SetFocus(Session& session, bool focused) {
  if (session.focused.exchange(focused) == focused) return;
  if (!focused) {
    pcm_backlog.Clear();
    link.HapticStop();
  }
  ReportSessionState();
}

void Instance::ReportSessionState() {
  protocol::SessionState state = protocol::SessionState::kNone;
  sessions.ForEach([&](const Session& session) {
    if (!session.running) return;
    state = std::max(state, session.focused ? protocol::SessionState::kFocused : protocol::SessionState::kBegun);
  });
  link.SetSession(state);
}

XrResult Instance::PollEvent(XrEventDataBuffer* event) {
  const XrResult result = next.PollEvent(handle, event);
  Alive();
  if (result == XR_SUCCESS && event) {
    if (event->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
      XrEventDataSessionStateChanged changed;
      std::memcpy(&changed, event, sizeof(changed));
      if (const auto session = sessions.Find(changed.session))
        SetFocus(*session, changed.state == XR_SESSION_STATE_FOCUSED);
    } else if (event->type == XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED) {
      // One event says that any profile of the session may have changed: ours is delivered with it.
      XrEventDataInteractionProfileChanged changed;
      std::memcpy(&changed, event, sizeof(changed));
      if (const auto session = sessions.Find(changed.session)) session->profile_event_due = false;
    }
    return result;
  }
  if (result != XR_EVENT_UNAVAILABLE || !event) return result;
  XrSession due = XR_NULL_HANDLE;
  sessions.ForEach([&](Session& session) {
    if (due == XR_NULL_HANDLE && session.running && session.profile_event_due.exchange(false)) due = session.handle;
  });
  if (due == XR_NULL_HANDLE) return events.Pop(*event) ? XR_SUCCESS : result;
  const XrEventDataInteractionProfileChanged changed{XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, nullptr, due};
  std::memcpy(event, &changed, sizeof(changed));
  return XR_SUCCESS;
}

XrResult Instance::WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state) {
  const XrResult result = next.WaitFrame(session, info, state);
  Alive();
  if (XR_SUCCEEDED(result) && state) clock.OnFrame(*state, MonotonicNow_ns());
  return result;
}

}  // namespace omni::layer
