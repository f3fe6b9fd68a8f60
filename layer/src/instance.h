// One XrInstance: what lies below us, what the application made, and our link to the service.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "layer/src/clock.h"
#include "layer/src/dispatch.h"
#include "layer/src/event_queue.h"
#include "layer/src/haptics.h"
#include "layer/src/log.h"
#include "layer/src/records.h"
#include "layer/src/service_link.h"
#include "layer/src/session.h"

namespace omni::layer {

struct InstanceSetup {
  XrInstance handle = XR_NULL_HANDLE;
  Dispatch next;
  std::vector<std::string> enabled;    // extensions that the application asked for, and "1.1" where it is such an app
  std::vector<std::string> only_ours;  // of those: unknown below, answered by us
  bool hide_timespec = false;          // enabled by us only: the application must not see it
  client::ConnectionInfo connection;
};

class Instance {
 public:
  explicit Instance(InstanceSetup setup);

  const XrInstance handle;
  const Dispatch next;
  const bool hide_timespec;
  Log log;
  const std::vector<Profile> profiles;
  const Hand hand;
  const XrPath hand_path;
  RuntimeClock clock;
  ServiceLink link;
  PcmBacklog pcm_backlog;
  EventQueue events;  // ours, delivered when nothing waits below

  HandleMap<XrSession, Session> sessions;
  HandleMap<XrActionSet, ActionSet> action_sets;
  HandleMap<XrAction, Action> actions;
  HandleMap<XrSpace, Space> spaces;

  // sessions.cc
  XrResult CreateSession(const XrSessionCreateInfo* info, XrSession* session);
  XrResult DestroySession(XrSession session);
  XrResult BeginSession(XrSession session, const XrSessionBeginInfo* info);
  XrResult EndSession(XrSession session);
  XrResult PollEvent(XrEventDataBuffer* event);

  // actions.cc
  XrResult CreateActionSet(const XrActionSetCreateInfo* info, XrActionSet* set);
  XrResult DestroyActionSet(XrActionSet set);
  XrResult CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action);
  XrResult DestroyAction(XrAction action);
  XrResult Attach(XrSession session, const XrSessionActionSetsAttachInfo* info);
  XrResult Sync(XrSession session, const XrActionsSyncInfo* info);

  // suggestions.cc
  XrResult Suggest(const XrInteractionProfileSuggestedBinding* suggested);
  XrResult CurrentProfile(XrSession session, XrPath user_path, XrInteractionProfileState* state);

  // action_states.cc
  XrResult GetBoolean(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* state);
  XrResult GetFloat(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* state);
  XrResult GetVector2f(XrSession session, const XrActionStateGetInfo* info, XrActionStateVector2f* state);
  XrResult GetPose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* state);

  // haptics.cc
  XrResult ApplyHaptic(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult StopHaptic(XrSession session, const XrHapticActionInfo* info);
  XrResult DeviceSampleRate(XrSession session, const XrHapticActionInfo* info, XrDevicePcmSampleRateStateFB* rate);

  // bound_sources.cc
  XrResult BoundSources(XrSession session, const XrBoundSourcesForActionEnumerateInfo* info, uint32_t capacity,
                        uint32_t* count, XrPath* sources);
  XrResult SourceName(XrSession session, const XrInputSourceLocalizedNameGetInfo* info, uint32_t capacity,
                      uint32_t* count, char* text);

  // spaces.cc
  XrResult CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space);
  XrResult CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space);
  XrResult DestroySpace(XrSpace space);
  XrResult LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location);

  XrResult WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state);

  // An extension that the application enabled, or "1.1".
  bool Enabled(std::string_view extension) const;

  // Sign of life and, when due, a look at the socket. Not from xrLocateSpace, which makes no system call.
  void Alive() {
    link.Beat();
    link.Poll(MonotonicNow_ns());
  }

  // Empty / XR_NULL_PATH where the runtime knows none.
  std::string PathText(XrPath path);
  XrPath PathOf(const std::string& text);

 private:
  bool OnlyOurs(const Profile& profile) const;
  bool OnlyOurs(std::string_view extension) const;  // enabled, and unknown below
  XrResult CheckSuggestions(const Profile& profile, const XrInteractionProfileSuggestedBinding& suggested);
  bool ProfileHasPath(const Profile& profile, std::string_view full_path) const;
  void SetFocus(Session& session, bool focused);
  void ReportSessionState();
  void UpdateSpaces(const Session& session);
  std::vector<ActiveSet> ActiveSets(const XrActionsSyncInfo& info) const;
  struct HapticRoute {
    bool to_pen = false;
    bool to_runtime = true;
  };
  HapticRoute RouteHaptic(XrSession session, const XrHapticActionInfo* info) const;
  XrResult ApplyTone(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult ApplyEnvelope(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult ApplyPcm(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult AskBelow(const HapticRoute& route, const char* extension, XrSession session, const XrHapticActionInfo* info,
                    const XrHapticBaseHeader* haptic);

  const std::vector<std::string> enabled_;
  const std::vector<std::string> only_ours_;

  std::mutex suggestions_mutex_;
  Suggestions suggestions_;

  std::mutex path_mutex_;
  std::unordered_map<XrPath, std::string> path_texts_;
  std::unordered_map<std::string, XrPath> paths_;
};

}  // namespace omni::layer
