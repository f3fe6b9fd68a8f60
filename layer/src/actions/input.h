// Action sets, actions, attachment and the sync, and what an application reads of them.
#pragma once

#include <vector>

#include "layer/src/actions/bindings.h"
#include "layer/src/vibration/vibrations.h"

namespace omni::layer {

class Input {
 public:
  Input(const Runtime& runtime, Records& records, ServiceLink& link, RuntimeClock& clock, Log& log, Bindings& bindings,
        Vibrations& vibrations)
      : runtime_(runtime),
        records_(records),
        link_(link),
        clock_(clock),
        log_(log),
        bindings_(bindings),
        vibrations_(vibrations) {}

  // actions.cc
  XrResult CreateActionSet(const XrActionSetCreateInfo* info, XrActionSet* set);
  XrResult DestroyActionSet(XrActionSet set);
  XrResult CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action);
  XrResult DestroyAction(XrAction action);
  XrResult AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info);
  // The runtime has synced, at `now_ns`.
  void Sync(Session& session, const XrActionsSyncInfo& info, bool focused, std::int64_t now_ns);

  // action_states.cc
  XrResult GetActionStateBoolean(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* state);
  XrResult GetActionStateFloat(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* state);
  XrResult GetActionStateVector2f(XrSession session, const XrActionStateGetInfo* info, XrActionStateVector2f* state);
  XrResult GetActionStatePose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* state);

  // bound_sources.cc
  XrResult EnumerateBoundSourcesForAction(XrSession session, const XrBoundSourcesForActionEnumerateInfo* info,
                                          uint32_t capacity, uint32_t* count, XrPath* sources);
  XrResult GetInputSourceLocalizedName(XrSession session, const XrInputSourceLocalizedNameGetInfo* info,
                                       uint32_t capacity, uint32_t* count, char* text);

 private:
  std::vector<ActiveSet> ActiveSets(const XrActionsSyncInfo& info) const;
  bool PutDown(Session& session, const PenSnapshot& pen);

  const Runtime& runtime_;
  Records& records_;
  ServiceLink& link_;
  RuntimeClock& clock_;
  Log& log_;
  Bindings& bindings_;
  Vibrations& vibrations_;
};

}  // namespace omni::layer
