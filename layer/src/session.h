// One XrSession: focus, actions, and the anchor space that ties the base to the runtime's world.
#pragma once

#include <atomic>
#include <shared_mutex>

#include "layer/src/pen_rest.h"
#include "layer/src/session_actions.h"

namespace omni::layer {

class Session {
 public:
  Session(XrSession xr_session, const std::vector<Profile>& profiles, const PenChoice& choice,
          const std::array<XrPath, 2>& hand_paths)
      : handle(xr_session), actions(profiles, choice, hand_paths) {}

  const XrSession handle;
  XrSpace anchor = XR_NULL_HANDLE;  // L: a LOCAL space of ours, where the base's placement is known

  std::atomic<bool> running{false};  // between xrBeginSession and xrEndSession
  std::atomic<bool> focused{false};
  std::atomic<bool> focus_was_lost{false};  // since the last sync
  std::atomic<bool> profile_event_due{false};

  // Guards `actions` and `rest`. Held over calls to the next layer's xrGetActionState*, never over its xrSyncActions.
  mutable std::shared_mutex mutex;
  SessionActions actions;
  PenRest rest;
};

}  // namespace omni::layer
