// The event queue and the session state machine. A session moves at most one state per xrPollEvent that finds the queue
// empty, so that an application meets every state in order and a test can stop between two.

#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

// Applications that never poll must not make the queue grow: beyond this, events are counted as lost.
constexpr size_t kMaxEvents = 256;

XrSessionState NextState(const Session& session, bool focus) {
  const bool exit = session.exit_requested;
  switch (session.state) {
    case XR_SESSION_STATE_UNKNOWN:
      return XR_SESSION_STATE_IDLE;
    case XR_SESSION_STATE_IDLE:
      return exit ? XR_SESSION_STATE_EXITING : XR_SESSION_STATE_READY;
    case XR_SESSION_STATE_READY:
      // Headless sessions need no frames.
      return session.running && (session.in_step || session.graphics == nullptr) ? XR_SESSION_STATE_SYNCHRONIZED
                                                                                 : session.state;
    case XR_SESSION_STATE_SYNCHRONIZED:
      return exit ? XR_SESSION_STATE_STOPPING : XR_SESSION_STATE_VISIBLE;
    case XR_SESSION_STATE_VISIBLE:
      if (exit) return XR_SESSION_STATE_SYNCHRONIZED;
      return focus ? XR_SESSION_STATE_FOCUSED : session.state;
    case XR_SESSION_STATE_FOCUSED:
      return exit ? XR_SESSION_STATE_VISIBLE : session.state;
    default:
      return session.state;
  }
}

void Advance(State& state, Instance& instance) {
  for (const auto& session : instance.sessions) {
    if (session->lost) continue;
    const XrSessionState next = NextState(*session, state.world.focus);
    if (next != session->state) SetSessionState(*session, next);
  }
}

XrResult Deliver(Instance& instance, XrEventDataBuffer* buffer) {
  if (instance.events_lost > 0) {
    const XrEventDataEventsLost lost{XR_TYPE_EVENT_DATA_EVENTS_LOST, nullptr, instance.events_lost};
    instance.events_lost = 0;
    std::memcpy(buffer, &lost, sizeof(lost));
    return XR_SUCCESS;
  }
  if (instance.events.empty()) return XR_EVENT_UNAVAILABLE;
  *buffer = instance.events.front();
  instance.events.pop_front();
  // The application has received the event: from here on nothing works but xrDestroyInstance.
  if (buffer->type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) instance.lost = true;
  return XR_SUCCESS;
}

}  // namespace

void PushEvent(Instance& instance, const XrEventDataBuffer& event) {
  if (instance.events.size() >= kMaxEvents) {
    ++instance.events_lost;
    return;
  }
  instance.events.push_back(event);
}

void SetSessionState(Session& session, XrSessionState next) {
  session.state = next;
  Push(*session.instance, XrEventDataSessionStateChanged{XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, nullptr,
                                                         Handles::As<XrSession>(session.handle), next, Now()});
}

void SendUserPresence(const State& state, Session& session) {
  if (session.lost || !session.instance->Enabled(XR_EXT_USER_PRESENCE_EXTENSION_NAME)) return;
  const XrBool32 is_present = state.world.user_present ? XR_TRUE : XR_FALSE;
  Push(*session.instance, XrEventDataUserPresenceChangedEXT{XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT, nullptr,
                                                            Handles::As<XrSession>(session.handle), is_present});
}

void ApplyFocus(State& state) {
  ForEachSession(state, [&state](Session& session) {
    if (session.lost || session.exit_requested) return;
    if (!state.world.focus && session.state == XR_SESSION_STATE_FOCUSED) {
      SetSessionState(session, XR_SESSION_STATE_VISIBLE);
    } else if (state.world.focus && session.state == XR_SESSION_STATE_VISIBLE) {
      SetSessionState(session, XR_SESSION_STATE_FOCUSED);
    }
  });
}

XrResult PollEvent(XrInstance instance, XrEventDataBuffer* buffer) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(buffer, XR_TYPE_EVENT_DATA_BUFFER), XR_ERROR_VALIDATION_FAILURE);
  RunScript(owner->script, Now());
  if (owner->events.empty()) Advance(state, *owner);
  return Deliver(*owner, buffer);
}

}  // namespace omni::runtime
