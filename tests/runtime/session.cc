// Creation, begin, end and exit of sessions; events.cc moves them from state to state.

#include <algorithm>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"
#include "tests/runtime/system.h"

namespace omni::runtime {

XrResult CreateSession(XrInstance instance, const XrSessionCreateInfo* info, XrSession* session) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_SESSION_CREATE_INFO) && session != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->createFlags == 0, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->systemId == kSystemId, XR_ERROR_SYSTEM_INVALID);
  const auto created = std::make_shared<Session>();
  const XrResult check = CreateGraphics(*owner, info->next, &created->graphics);
  if (XR_FAILED(check)) return check;
  created->instance = owner;
  *session = Handles::As<XrSession>(state.handles.Insert(created));
  owner->sessions.push_back(created);
  return XR_SUCCESS;
}

// Allowed on a lost session too.
XrResult DestroySession(XrSession session) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  const auto doomed = state.handles.Share<Session>(session);
  OMNI_REQUIRE(doomed != nullptr, XR_ERROR_HANDLE_INVALID);
  for (const uint64_t child : doomed->children) state.handles.Erase(child);
  state.handles.Erase(doomed->handle);
  std::erase(doomed->instance->sessions, doomed);
  return XR_SUCCESS;
}

XrResult BeginSession(XrSession session, const XrSessionBeginInfo* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_SESSION_BEGIN_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(!owner->running, XR_ERROR_SESSION_RUNNING);
  OMNI_REQUIRE(owner->state == XR_SESSION_STATE_READY, XR_ERROR_SESSION_NOT_READY);
  if (const XrResult check = CheckViewConfiguration(info->primaryViewConfigurationType); XR_FAILED(check)) return check;
  owner->running = true;
  owner->frame_waited = owner->frame_begun = owner->in_step = false;
  owner->next_frame = 0;
  SendUserPresence(state, *owner);
  return XR_SUCCESS;
}

XrResult EndSession(XrSession session) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(owner->running, XR_ERROR_SESSION_NOT_RUNNING);
  OMNI_REQUIRE(owner->state == XR_SESSION_STATE_STOPPING, XR_ERROR_SESSION_NOT_STOPPING);
  owner->running = false;
  SetSessionState(*owner, XR_SESSION_STATE_IDLE);
  return XR_SUCCESS;
}

XrResult RequestExitSession(XrSession session) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(owner->running, XR_ERROR_SESSION_NOT_RUNNING);
  owner->exit_requested = true;
  return XR_SUCCESS;
}

}  // namespace omni::runtime
