// The functions of XR_OMNIX1_force_feedback. There is one handle at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "layer/include/openxr/omni_force_feedback.h"
#include "layer/src/force/force_rules.h"
#include "layer/src/instance/event_queue.h"
#include "layer/src/instance/session.h"
#include "layer/src/spaces/locator.h"

namespace omni::layer {

// One XrForceFeedbackOMNIX1.
struct ForceFeedback {
  ForceFeedback(std::shared_ptr<Session> of, const ForceStatus& at_first) : session(std::move(of)), watch(at_first) {}

  // Unique among live records.
  XrForceFeedbackOMNIX1 handle() noexcept { return reinterpret_cast<XrForceFeedbackOMNIX1>(this); }

  const std::shared_ptr<Session> session;

  std::mutex mutex;                          // of what follows; never held during a call to the next layer
  std::vector<LocalConstraint> constraints;  // as set
  std::uint64_t constraint_changes = 0;      // of that list
  protocol::ForceConstraints sent;           // as last sent to the service ...
  std::uint64_t sent_connection = 0;         // ... over this connection
  ForceStatusWatch watch;
};

class ForceFeedbacks {
 public:
  ForceFeedbacks(const Runtime& runtime, const Records& records, ServiceLink& link, const RuntimeClock& clock,
                 EventQueue& events, Locator& locator)
      : runtime_(runtime), records_(records), link_(link), clock_(clock), events_(events), locator_(locator) {}

  bool Contains(XrForceFeedbackOMNIX1 force) const { return forces_.Contains(force); }

  // force_feedbacks.cc
  XrResult Create(XrSession session, const XrForceFeedbackCreateInfoOMNIX1* info, XrForceFeedbackOMNIX1* force);
  XrResult Destroy(XrForceFeedbackOMNIX1 force);
  XrResult Apply(XrForceFeedbackOMNIX1 force, const XrForceApplyInfoOMNIX1* info);
  XrResult SetConstraints(XrForceFeedbackOMNIX1 force, const XrForceFeedbackConstraintsSetInfoOMNIX1* info);
  XrResult Stop(XrForceFeedbackOMNIX1 force);

  // force_queries.cc
  XrResult GetProperties(XrForceFeedbackOMNIX1 force, const XrForceFeedbackPropertiesGetInfoOMNIX1* info,
                         XrForceFeedbackPropertiesOMNIX1* properties);
  XrResult GetState(XrForceFeedbackOMNIX1 force, const XrForceFeedbackStateGetInfoOMNIX1* info,
                    XrForceFeedbackStateOMNIX1* state);

  // Constraints follow their spaces, and are sent again to a service that has restarted.
  void FollowConstraints();
  // Queues an event for each change of state.
  void QueueStateEvents();
  void OnFocusLost(const Session& session);
  void ForgetSpace(XrSpace space);
  void EndOf(XrSession session);
  // A state event whose handle is no more.
  bool IsOfDestroyed(const XrEventDataBuffer& event) const;

 private:
  void SendConstraints(ForceFeedback& force, const protocol::ForceConstraints& message);
  ForceStatus StatusNow(const Session& session);

  const Runtime& runtime_;
  const Records& records_;
  ServiceLink& link_;
  const RuntimeClock& clock_;
  EventQueue& events_;
  Locator& locator_;
  HandleMap<XrForceFeedbackOMNIX1, ForceFeedback> forces_;
  std::mutex mutex_;  // of creation and destruction
};

}  // namespace omni::layer
