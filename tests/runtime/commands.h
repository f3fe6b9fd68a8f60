#pragma once
// What can happen to the world and the sessions in it: said once, for the hooks and for the script. The caller holds
// the state exclusively. False: refused.

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
bool Recenter(State& state, const XrPosef& pose_in_local, XrDuration delay_ns);
bool RequestExit(State& state);
bool LoseSessions(State& state);
bool LoseInstances(State& state);

}  // namespace omni::runtime
