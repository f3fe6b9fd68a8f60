// Actions, from suggested bindings to the states that an application reads.
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "layer/src/actions/binding_modifications.h"
#include "layer/src/actions/session_actions.h"
#include "layer/src/instance/runtime.h"
#include "layer/src/instance/session.h"
#include "layer/src/vibration/vibrations.h"

namespace omni::layer {

// Suggested bindings and the profile that is current.
class Bindings {
 public:
  Bindings(const Runtime& runtime, const Records& records, ServiceLink& link, const std::vector<Profile>& profiles)
      : runtime_(runtime), records_(records), link_(link), profiles_(profiles) {}

  XrResult SuggestInteractionProfileBindings(const XrInteractionProfileSuggestedBinding* suggested);
  XrResult GetCurrentInteractionProfile(XrSession session, XrPath user_path, XrInteractionProfileState* state);

  // All that were suggested until now.
  Suggestions Suggested() const;

  // What the runtime alone would show for a hand.
  XrPath ProfileBelow(XrSession session, XrPath user_path) const;
  // `before` and `after` differ: an event is due if the application sees another profile than before.
  void NotifyProfileChange(Session& session, XrPath user_path, const Profile* before, const Profile* after);

 private:
  bool OnlyOurs(const Profile& profile) const;
  bool OnlyOurs(const Profile& profile, std::string_view full_path) const;
  XrResult CheckSuggestions(const Profile& profile, const std::vector<XrActionSuggestedBinding>& suggested);
  XrResult Forward(const XrInteractionProfileSuggestedBinding& suggested, const Profile* known);
  void Record(const std::string& profile_path, const XrInteractionProfileSuggestedBinding& suggested,
              const std::vector<BindingThreshold>& thresholds);

  const Runtime& runtime_;
  const Records& records_;
  ServiceLink& link_;
  const std::vector<Profile>& profiles_;
  mutable std::mutex mutex_;
  Suggestions suggestions_;
};

// Action sets, actions, attachment and the sync, and what an application reads of them.
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
