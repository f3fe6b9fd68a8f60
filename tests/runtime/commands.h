#pragma once
// What can happen to the world and the sessions in it, for both the hooks and the script. The caller holds the state
// exclusively. False: rejected.

#include <openxr/openxr.h>

#include <string_view>

#include "tests/runtime/state.h"

namespace omni::runtime {

// "left" 0, "right" 1, else -1.
int HandIndex(std::string_view hand);

bool ResetWorld(State& state);
bool SetTracking(State& state, int hand, bool valid, bool tracked);
bool SetHead(State& state, const Motion& motion);
bool SetFocus(State& state, bool focus);
// The headset is put on or taken off.
bool SetUserPresence(State& state, bool present);
bool SetHand(State& state, int hand, bool active, const Motion& palm);
// "local", "local_floor" or "stage", else XR_REFERENCE_SPACE_TYPE_MAX_ENUM.
XrReferenceSpaceType SpaceNamed(std::string_view name);
// LOCAL (with LOCAL_FLOOR) or STAGE moves. `reported`: the event has the new origin.
bool Recenter(State& state, XrReferenceSpaceType space, const XrPosef& pose, XrDuration delay_ns, bool reported);
bool RequestExit(State& state);
bool LoseSessions(State& state);
bool LoseInstances(State& state);
// The runtime dies: no event, every function returns XR_ERROR_INSTANCE_LOST at once.
bool KillRuntime(State& state);

}  // namespace omni::runtime
