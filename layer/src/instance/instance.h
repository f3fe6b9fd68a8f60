// One XrInstance: what lies below us, what the application made, and our link to the service.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "layer/src/actions/bindings.h"
#include "layer/src/actions/input.h"
#include "layer/src/entry/dispatch.h"
#include "layer/src/force/force_feedbacks.h"
#include "layer/src/instance/clock.h"
#include "layer/src/instance/event_queue.h"
#include "layer/src/instance/log.h"
#include "layer/src/instance/records.h"
#include "layer/src/instance/session.h"
#include "layer/src/models/render_models.h"
#include "layer/src/scene/haptic_scene.h"
#include "layer/src/service/service_link.h"
#include "layer/src/spaces/alignment.h"
#include "layer/src/spaces/locator.h"
#include "layer/src/vibration/vibrations.h"
#include "service/base/clock.h"

namespace omni::layer {

struct InstanceSetup {
  XrInstance handle = XR_NULL_HANDLE;
  Dispatch next;
  std::vector<std::string> enabled;    // extensions that the application asked for, and "1.1" where it is such an app
  std::vector<std::string> only_ours;  // of those: unknown below, answered by us
  bool hide_timespec = false;          // enabled by us only: the application must not see it
  bool hide_presence = false;          // the same: its events
  client::ConnectionInfo connection;
};

class Instance {
 public:
  explicit Instance(InstanceSetup setup);

  const XrInstance handle;
  const Dispatch next;
  const bool hide_timespec;
  const bool hide_presence;
  Log log;
  const std::vector<Profile> profiles;
  const std::array<XrPath, 2> hand_paths;  // by Hand
  RuntimeClock clock;
  ServiceLink link;
  EventQueue events;  // ours, delivered when the runtime has none

  HandleMap<XrSession, Session> sessions;
  HandleMap<XrActionSet, ActionSet> action_sets;
  HandleMap<XrAction, Action> actions;
  HandleMap<XrSpace, Space> spaces;
  HandleMap<XrHandTrackerEXT, Session> hand_trackers;  // to their sessions
  HandleMap<XrRenderModelEXT, RenderModel> render_model_handles;
  HandleMap<XrRenderModelAssetEXT, RenderModelAsset> render_model_assets;
  HandleMap<XrForceFeedbackOMNIX1, ForceFeedback> forces;

  // The functions, a class per subject. Those of sessions, events and the instance itself are below.
  Input input{*this};
  Bindings bindings{*this};
  Locator locator{*this};
  Alignment alignment{*this};
  Vibrations vibrations{*this};
  ForceFeedbacks force_feedbacks{*this};
  HapticScenes haptic_scenes{sessions, link, clock, events, locator};
  RenderModels render_models{*this};
  auto Parts() noexcept {
    return std::tie(*this, input, bindings, locator, alignment, vibrations, force_feedbacks, haptic_scenes,
                    render_models);
  }

  // sessions.cc
  XrResult CreateSession(const XrSessionCreateInfo* info, XrSession* session);
  XrResult DestroySession(XrSession session);
  XrResult BeginSession(XrSession session, const XrSessionBeginInfo* info);
  XrResult EndSession(XrSession session);
  XrResult PollEvent(XrEventDataBuffer* event);

  // The runtime does not know the names of our own enumerants.
  XrResult ResultToString(XrResult value, char* buffer);
  XrResult StructureTypeToString(XrStructureType value, char* buffer);

  XrResult GetSystemProperties(XrSystemId system, XrSystemProperties* properties);  // force_queries.cc
  XrResult WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state);

  // An extension that the application enabled, or "1.1".
  bool Enabled(std::string_view extension) const;
  bool OnlyOurs(std::string_view extension) const;  // enabled, and unknown below
  // All that the application enabled, and those of them that the runtime knows.
  const std::vector<std::string>& enabled() const noexcept { return enabled_; }
  const std::vector<std::string>& enabled_below() const noexcept { return enabled_below_; }

  void SetFocus(Session& session, bool focused);
  // A call returned XR_ERROR_INSTANCE_LOST or XR_ERROR_SESSION_LOST. A session that lives on has focus at its next
  // sync.
  void OnLoss();

  // Updates the heartbeat and, when due, polls the socket. Not from xrLocateSpace, which makes no system call.
  void Alive() {
    link.Beat();
    link.Poll(base::MonotonicNow_ns());
    alignment.Poll();
  }

  // The pen's hand and preferred profile: from the environment, else from the service.
  PenChoice Choice() const;

  // Empty / XR_NULL_PATH where the runtime knows none.
  std::string PathText(XrPath path);
  XrPath PathOf(const std::string& text);

 private:
  void ReportSessionState();
  // The runtime's next event for the application.
  XrResult PollBelow(XrEventDataBuffer* event);
  void OnUserPresence(const XrEventDataUserPresenceChangedEXT& changed);

  const std::vector<std::string> enabled_;
  const std::vector<std::string> only_ours_;
  const std::vector<std::string> enabled_below_;  // enabled_ without only_ours_
  const std::optional<Hand> fixed_hand_;          // by the environment
  const std::string fixed_profile_;

  std::mutex path_mutex_;
  std::unordered_map<XrPath, std::string> path_texts_;
  std::unordered_map<std::string, XrPath> paths_;
};

}  // namespace omni::layer
