// One XrSession: focus, actions, and the anchor spaces that tie the base to the runtime's world.
#pragma once

#include <array>
#include <atomic>
#include <shared_mutex>

#include "layer/src/actions/pen.h"
#include "layer/src/actions/session_actions.h"
#include "layer/src/spaces/base_pose.h"

namespace omni::layer {

// Spaces in which the base's pose can be given, the most stable first: STAGE is rarely recentred.
inline constexpr std::array kAnchorTypes{XR_REFERENCE_SPACE_TYPE_STAGE,
                                         static_cast<XrReferenceSpaceType>(kReferenceSpaceTypeLocalFloor),
                                         XR_REFERENCE_SPACE_TYPE_LOCAL};

class Session {
 public:
  Session(XrSession xr_session, const std::vector<Profile>& profiles, const PenChoice& choice,
          const std::array<XrPath, 2>& hand_paths)
      : handle(xr_session), actions(profiles, choice, hand_paths) {}

  const XrSession handle;

  // Where the base stands, in one of the anchors. Set from any thread, read by every query about the pen.
  BasePoseHistory base_pose;

  // A space of ours at the natural origin of each of kAnchorTypes that the runtime offers; else XR_NULL_HANDLE. Made
  // with the session, fixed from then on.
  std::array<XrSpace, kAnchorTypes.size()> anchors{};
  XrSpace AnchorSpace(XrReferenceSpaceType type) const {
    for (std::size_t i = 0; i < kAnchorTypes.size(); ++i)
      if (kAnchorTypes[i] == type) return anchors[i];
    return XR_NULL_HANDLE;
  }
  // The most stable one offered, the best for measuring a new base pose. LOCAL if nothing is.
  XrReferenceSpaceType PreferredAnchor() const {
    for (std::size_t i = 0; i < kAnchorTypes.size(); ++i)
      if (anchors[i] != XR_NULL_HANDLE) return kAnchorTypes[i];
    return XR_REFERENCE_SPACE_TYPE_LOCAL;
  }

  std::atomic<bool> running{false};  // between xrBeginSession and xrEndSession
  std::atomic<bool> focused{false};
  std::atomic<bool> user_away{false};       // the headset is not worn, says XR_EXT_user_presence
  std::atomic<bool> focus_was_lost{false};  // since the last sync
  std::atomic<bool> profile_event_due{false};

  // Guards `actions`, `pen` and `rest`. Held over calls to the next layer's xrGetActionState*, never over its
  // xrSyncActions.
  mutable std::shared_mutex mutex;
  SessionActions actions;
  PenSnapshot pen;  // as the last sync saw it
  PenRest rest;
};

}  // namespace omni::layer
