#include "tests/runtime/commands.h"

#include "tests/runtime/clock.h"

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

bool Recenter(State& state, const XrPosef& pose_in_local, XrDuration delay_ns) {
  if (!IsValid(pose_in_local) || delay_ns < 0) return false;
  const XrTime when = Now() + delay_ns;
  state.world.Recenter(pose_in_local, when);
  ForEachSession(state, [&](Session& session) {
    Push(*session.instance,
         XrEventDataReferenceSpaceChangePending{XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING, nullptr,
                                                Handles::As<XrSession>(session.handle), XR_REFERENCE_SPACE_TYPE_LOCAL,
                                                when, XR_TRUE, Normalized(pose_in_local)});
  });
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

bool LoseInstances(State& state) {
  for (const auto& instance : state.instances) {
    Push(*instance, XrEventDataInstanceLossPending{XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, nullptr, Now()});
  }
  return true;
}

}  // namespace omni::runtime
