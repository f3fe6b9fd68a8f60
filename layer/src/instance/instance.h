// One XrInstance: what lies below us, what the application made, and our link to the service.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "layer/src/entry/dispatch.h"
#include "layer/src/force/force_feedback.h"
#include "layer/src/instance/clock.h"
#include "layer/src/instance/event_queue.h"
#include "layer/src/instance/log.h"
#include "layer/src/instance/records.h"
#include "layer/src/instance/session.h"
#include "layer/src/scene/haptic_scene.h"
#include "layer/src/service/service_link.h"
#include "layer/src/spaces/locate.h"
#include "layer/src/vibration/haptics.h"
#include "service/base/clock.h"

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
  const std::array<XrPath, 2> hand_paths;  // by Hand
  RuntimeClock clock;
  ServiceLink link;
  PcmBacklog pcm_backlog;
  EventQueue events;  // ours, delivered when the runtime has none

  HandleMap<XrSession, Session> sessions;
  HandleMap<XrActionSet, ActionSet> action_sets;
  HandleMap<XrAction, Action> actions;
  HandleMap<XrSpace, Space> spaces;
  HandleMap<XrHandTrackerEXT, Session> hand_trackers;  // to their sessions
  HandleMap<XrForceFeedbackOMNIX1, ForceFeedback> forces;
  HapticScenes haptic_scenes{*this};

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
  XrResult AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info);
  XrResult SyncActions(XrSession session, const XrActionsSyncInfo* info);

  // suggestions.cc
  XrResult SuggestInteractionProfileBindings(const XrInteractionProfileSuggestedBinding* suggested);
  XrResult GetCurrentInteractionProfile(XrSession session, XrPath user_path, XrInteractionProfileState* state);

  // action_states.cc
  XrResult GetActionStateBoolean(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* state);
  XrResult GetActionStateFloat(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* state);
  XrResult GetActionStateVector2f(XrSession session, const XrActionStateGetInfo* info, XrActionStateVector2f* state);
  XrResult GetActionStatePose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* state);

  // haptics.cc
  XrResult ApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult StopHapticFeedback(XrSession session, const XrHapticActionInfo* info);
  XrResult GetDeviceSampleRateFB(XrSession session, const XrHapticActionInfo* info, XrDevicePcmSampleRateStateFB* rate);

  // bound_sources.cc
  XrResult EnumerateBoundSourcesForAction(XrSession session, const XrBoundSourcesForActionEnumerateInfo* info,
                                          uint32_t capacity, uint32_t* count, XrPath* sources);
  XrResult GetInputSourceLocalizedName(XrSession session, const XrInputSourceLocalizedNameGetInfo* info,
                                       uint32_t capacity, uint32_t* count, char* text);

  // spaces.cc
  XrResult CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space);
  XrResult CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space);
  XrResult DestroySpace(XrSpace space);
  XrResult LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location);

  // locate_many.cc
  XrResult LocateSpaces(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* locations);
  XrResult LocateSpacesKHR(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* locations);

  // locate_from_pen.cc
  XrResult LocateViews(XrSession session, const XrViewLocateInfo* info, XrViewState* state, uint32_t capacity,
                       uint32_t* count, XrView* views);
  XrResult CreateHandTrackerEXT(XrSession session, const XrHandTrackerCreateInfoEXT* info, XrHandTrackerEXT* tracker);
  XrResult DestroyHandTrackerEXT(XrHandTrackerEXT tracker);
  XrResult LocateHandJointsEXT(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT* info,
                               XrHandJointLocationsEXT* locations);

  // end_frame.cc
  XrResult EndFrame(XrSession session, const XrFrameEndInfo* info);
  // Where a space is in the base frame. Flags are 0 if it cannot be located; errors in space and time are the
  // runtime's.
  XrResult LocateInBase(const Session& session, XrSpace space, XrTime time, Located& X_OS);

  // force_feedback.cc
  XrResult CreateForceFeedback(XrSession session, const XrForceFeedbackCreateInfoOMNIX1* info,
                               XrForceFeedbackOMNIX1* force);
  XrResult DestroyForceFeedback(XrForceFeedbackOMNIX1 force);
  XrResult ApplyForce(XrForceFeedbackOMNIX1 force, const XrForceApplyInfoOMNIX1* info);
  XrResult SetConstraints(XrForceFeedbackOMNIX1 force, const XrForceFeedbackConstraintsSetInfoOMNIX1* info);
  XrResult StopForce(XrForceFeedbackOMNIX1 force);

  // The runtime does not know the names of our own enumerants.
  XrResult ResultToString(XrResult value, char* buffer);
  XrResult StructureTypeToString(XrStructureType value, char* buffer);

  // force_queries.cc
  XrResult GetSystemProperties(XrSystemId system, XrSystemProperties* properties);
  XrResult ForceProperties(XrForceFeedbackOMNIX1 force, const XrForceFeedbackPropertiesGetInfoOMNIX1* info,
                           XrForceFeedbackPropertiesOMNIX1* properties);
  XrResult ForceState(XrForceFeedbackOMNIX1 force, const XrForceFeedbackStateGetInfoOMNIX1* info,
                      XrForceFeedbackStateOMNIX1* state);

  XrResult WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state);

  // An extension that the application enabled, or "1.1".
  bool Enabled(std::string_view extension) const;

  // Updates the heartbeat and, when due, polls the socket. Not from xrLocateSpace, which makes no system call.
  void Alive() {
    link.Beat();
    link.Poll(base::MonotonicNow_ns());
    PopBasePose();
  }

  // The pen's hand and preferred profile: from the environment, else from the service.
  PenChoice Choice() const;

  // Empty / XR_NULL_PATH where the runtime knows none.
  std::string PathText(XrPath path);
  XrPath PathOf(const std::string& text);

 private:
  bool OnlyOurs(const Profile& profile) const;
  bool OnlyOurs(const Profile& profile, std::string_view full_path) const;
  bool OnlyOurs(std::string_view extension) const;  // enabled, and unknown below
  XrResult CheckSuggestions(const Profile& profile, const std::vector<XrActionSuggestedBinding>& suggested);
  XrResult Forward(const XrInteractionProfileSuggestedBinding& suggested, const Profile* known);
  void Record(const std::string& profile_path, const XrInteractionProfileSuggestedBinding& suggested,
              const std::vector<BindingThreshold>& thresholds);
  bool PutDown(Session& session, const PenSnapshot& pen);
  XrPath ProfileBelow(XrSession session, XrPath user_path) const;
  void NotifyProfileChange(Session& session, XrPath user_path, const Profile* before, const Profile* after);
  void SetFocus(Session& session, bool focused);
  void ReportSessionState();
  void UpdateSpaces(const Session& session);
  void MakeAnchors(Session& session);
  XrResult LocateSpacesThrough(PFN_xrLocateSpaces below, XrSession session, const XrSpacesLocateInfo* info,
                               XrSpaceLocations* locations);
  // alignment.cc
  void RequestBasePose(Session& session, XrSystemId system);
  void PopBasePose();
  void OnSpaceChange(XrEventDataReferenceSpaceChangePending change);
  bool ReportChange(const XrEventDataReferenceSpaceChangePending& change);
  std::vector<ActiveSet> ActiveSets(const XrActionsSyncInfo& info) const;
  // force_feedback.cc, force_queries.cc
  void DestroyForcesOf(XrSession session);
  void ForgetForces(const Session& session);  // it has lost the focus
  void ForgetSpace(XrSpace space);
  void FollowConstraints();
  void SendConstraints(ForceFeedback& force, const protocol::ForceConstraints& message);
  ForceStatus StatusNow(const Session& session);
  void WatchForces();
  bool IsOfDestroyedForce(const XrEventDataBuffer& event) const;

  struct HapticRoute {
    bool to_pen = false;
    bool to_runtime = true;
  };
  HapticRoute RouteHaptic(XrSession session, const XrHapticActionInfo* info) const;
  XrResult ApplyTone(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult ApplyEnvelope(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult ApplyPcm(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic);
  XrResult ShapeBelow(bool only_ours, XrSession session, const XrHapticActionInfo* info,
                      const XrHapticBaseHeader* haptic, const std::optional<ShapedVibration>& shaped) const;
  void Play(const Pulse& pulse);
  std::uint32_t PlayPcm(XrAction action, ShapedVibration& pcm);

  const std::vector<std::string> enabled_;
  const std::vector<std::string> only_ours_;
  const std::vector<std::string> enabled_below_;  // enabled_ without only_ours_
  const std::optional<Hand> fixed_hand_;          // by the environment
  const std::string fixed_profile_;

  std::mutex forces_mutex_;  // there is one handle at a time
  std::mutex placement_mutex_;
  std::optional<protocol::BasePose> placed_;  // as last received from the service

  std::mutex suggestions_mutex_;
  Suggestions suggestions_;

  std::mutex path_mutex_;
  std::unordered_map<XrPath, std::string> path_texts_;
  std::unordered_map<std::string, XrPath> paths_;
};

}  // namespace omni::layer
