#include "tests/runtime/commands.h"

#include "tests/runtime/newer_openxr.h"
#include "tests/runtime/spaces/clock.h"

namespace omni::runtime {

int HandIndex(std::string_view hand) {
  if (hand == "left") return 0;
  return hand == "right" ? 1 : -1;
}

bool ResetWorld(State& state) {
  state.world.Reset();
  ApplyFocus(state);
  return true;
}

bool SetTracking(State& state, int hand, bool valid, bool tracked) {
  if (hand < 0 || (tracked && !valid)) return false;
  state.world.devices[hand].valid = valid;
  state.world.devices[hand].tracked = tracked;
  return true;
}

bool SetHead(State& state, const Motion& motion) {
  if (!IsValid(motion.pose)) return false;
  state.world.SetHead(motion);
  return true;
}

bool SetFocus(State& state, bool focus) {
  state.world.focus = focus;
  ApplyFocus(state);
  return true;
}

bool SetUserPresence(State& state, bool present) {
  state.world.user_present = present;
  ForEachSession(state, [&state](Session& session) { SendUserPresence(state, session); });
  return true;
}

bool SetHand(State& state, int hand, bool active, const Motion& palm) {
  if (hand < 0 || !IsValid(palm.pose)) return false;
  state.world.SetHand(hand, active, palm);
  return true;
}

XrReferenceSpaceType SpaceNamed(std::string_view name) {
  if (name == "local") return XR_REFERENCE_SPACE_TYPE_LOCAL;
  if (name == "local_floor") return kLocalFloor;
  return name == "stage" ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_MAX_ENUM;
}

namespace {

// Sends every session the event that `space` moves at `when`, with the world's new origin.
void SendSpaceChange(State& state, XrReferenceSpaceType space, XrTime when, bool reported) {
  const XrBool32 known = reported ? XR_TRUE : XR_FALSE;
  const XrPosef before = state.world.OriginAt(space, when - 1);
  const XrPosef in_previous = Normalized(Compose(Inverse(before), state.world.OriginAt(space, when)));
  ForEachSession(state, [&](Session& session) {
    if (space == kLocalFloor && !session.instance->version_1_1) return;
    Push(*session.instance,
         XrEventDataReferenceSpaceChangePending{XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING, nullptr,
                                                Handles::As<XrSession>(session.handle), space, when, known,
                                                reported ? in_previous : XrPosef{}});
  });
}

}  // namespace

bool Recenter(State& state, XrReferenceSpaceType space, const XrPosef& pose, XrDuration delay_ns, bool reported) {
  const bool movable = space == XR_REFERENCE_SPACE_TYPE_LOCAL || space == XR_REFERENCE_SPACE_TYPE_STAGE;
  if (!movable || !IsValid(pose) || delay_ns < 0) return false;
  const XrTime when = Now() + delay_ns;
  state.world.Recenter(space, pose, when);
  SendSpaceChange(state, space, when, reported);
  if (space == XR_REFERENCE_SPACE_TYPE_LOCAL) SendSpaceChange(state, kLocalFloor, when, reported);
  return true;
}

bool RequestExit(State& state) {
  ForEachSession(state, [](Session& session) { session.exit_requested |= session.running; });
  return true;
}

bool LoseSessions(State& state) {
  ForEachSession(state, [](Session& session) {
    if (session.lost) return;
    SetSessionState(session, XR_SESSION_STATE_LOSS_PENDING);
    session.lost = true;
  });
  return true;
}

bool KillRuntime(State& state) {
  for (const auto& instance : state.instances) instance->lost = true;
  return true;
}

bool LoseInstances(State& state) {
  for (const auto& instance : state.instances) {
    Push(*instance, XrEventDataInstanceLossPending{XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, nullptr, Now()});
  }
  return true;
}

}  // namespace omni::runtime
