// Action sets, actions, attachment and the sync, and what an application reads of them.
#pragma once

#include <vector>

#include "layer/src/actions/session_actions.h"
#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/instance/session.h"

namespace omni::layer {

class Instance;

class Input {
 public:
  explicit Input(Instance& instance) : instance_(instance) {}

  // actions.cc
  XrResult CreateActionSet(const XrActionSetCreateInfo* info, XrActionSet* set);
  XrResult DestroyActionSet(XrActionSet set);
  XrResult CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action);
  XrResult DestroyAction(XrAction action);
  XrResult AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info);
  XrResult SyncActions(XrSession session, const XrActionsSyncInfo* info);

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
  void Sync(Session& session, const XrActionsSyncInfo& info, bool focused);

  Instance& instance_;
};

}  // namespace omni::layer
