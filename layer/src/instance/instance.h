// One XrInstance: what lies below us, what the application made, and our link to the service.
#pragma once

#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "layer/src/actions/input.h"
#include "layer/src/force/force_feedbacks.h"
#include "layer/src/instance/clock.h"
#include "layer/src/instance/event_queue.h"
#include "layer/src/instance/log.h"
#include "layer/src/instance/runtime.h"
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

  const Runtime runtime;
  const bool hide_timespec;
  const bool hide_presence;
  Log log;
  const std::vector<Profile> profiles;
  RuntimeClock clock;
  ServiceLink link;
  EventQueue events;  // ours, delivered when the runtime has none
  Records records;

  // The functions, a class per subject. Those of sessions, events, the instance itself, and those that concern several
  // subjects are below.
  Bindings bindings{runtime, records, link, profiles};
  Locator locator{runtime, records, link, clock, log};
  Alignment alignment{runtime, records, link, clock, log};
  Vibrations vibrations{runtime, records, link};
  Input input{runtime, records, link, clock, log, bindings, vibrations};
  ForceFeedbacks force_feedbacks{runtime, records, link, clock, events, locator};
  HapticScenes haptic_scenes{records.sessions, link, clock, events, locator};
  RenderModels render_models{runtime, records, link};
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
  XrResult SyncActions(XrSession session, const XrActionsSyncInfo* info);
  XrResult DestroySpace(XrSpace space);

  // The runtime does not know the names of our own enumerants.
  XrResult ResultToString(XrResult value, char* buffer);
  XrResult StructureTypeToString(XrStructureType value, char* buffer);

  XrResult GetSystemProperties(XrSystemId system, XrSystemProperties* properties);  // force_queries.cc
  XrResult WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state);

  void SetFocus(Session& session, bool focused);
  // A call returned XR_ERROR_INSTANCE_LOST or XR_ERROR_SESSION_LOST. A session that lives on has focus at its next
  // sync.
  void OnLoss();

  // Updates the heartbeat and, when due, polls the socket. Not from xrLocateSpace, which makes no system call.
  void KeepAlive() {
    link.SignalAlive();
    link.Poll(base::MonotonicNow_ns());
    alignment.Poll();
  }

 private:
  void ReportSessionState();
  // The runtime's next event for the application.
  XrResult PollBelow(XrEventDataBuffer* event);
  void OnUserPresence(const XrEventDataUserPresenceChangedEXT& changed);
};

}  // namespace omni::layer
