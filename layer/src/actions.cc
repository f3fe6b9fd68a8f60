// Action sets, actions, attachment and the sync, the one place where anything of them changes.
#include <cstring>
#include <string>

#include "layer/src/fault.h"
#include "layer/src/instance.h"

namespace omni::layer {
namespace {

// The runtime's part of each action, through its own queries.
class NextStates : public RuntimeStates {
 public:
  NextStates(const Dispatch& next, XrSession session) : next_(next), session_(session) {}

  StatePart Query(const Action& action, XrPath subaction) const override {
    if (action.destroyed && !OMNI_FAULT("destroyed-handle-used")) return {};
    const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action.handle, subaction};
    switch (action.type) {
      case XR_ACTION_TYPE_BOOLEAN_INPUT: {
        XrActionStateBoolean s{XR_TYPE_ACTION_STATE_BOOLEAN, nullptr, XR_FALSE, XR_FALSE, 0, XR_FALSE};
        if (XR_FAILED(next_.GetActionStateBoolean(session_, &info, &s))) return {};
        return {s.isActive == XR_TRUE, {s.currentState ? 1.0f : 0.0f, 0}, s.lastChangeTime};
      }
      case XR_ACTION_TYPE_FLOAT_INPUT: {
        XrActionStateFloat s{XR_TYPE_ACTION_STATE_FLOAT, nullptr, 0, XR_FALSE, 0, XR_FALSE};
        if (XR_FAILED(next_.GetActionStateFloat(session_, &info, &s))) return {};
        return {s.isActive == XR_TRUE, {s.currentState, 0}, s.lastChangeTime};
      }
      case XR_ACTION_TYPE_VECTOR2F_INPUT: {
        XrActionStateVector2f s{XR_TYPE_ACTION_STATE_VECTOR2F, nullptr, {0, 0}, XR_FALSE, 0, XR_FALSE};
        if (XR_FAILED(next_.GetActionStateVector2f(session_, &info, &s))) return {};
        return {s.isActive == XR_TRUE, s.currentState, s.lastChangeTime};
      }
      case XR_ACTION_TYPE_POSE_INPUT: {
        XrActionStatePose s{XR_TYPE_ACTION_STATE_POSE, nullptr, XR_FALSE};
        if (XR_FAILED(next_.GetActionStatePose(session_, &info, &s))) return {};
        return {s.isActive == XR_TRUE, {0, 0}, 0};
      }
      default:
        return {};
    }
  }

 private:
  const Dispatch& next_;
  XrSession session_;
};

}  // namespace

XrResult Instance::CreateActionSet(const XrActionSetCreateInfo* info, XrActionSet* set) {
  const XrResult result = next.CreateActionSet(handle, info, set);
  link.Beat();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<ActionSet>();
  record->handle = *set;
  record->priority = info->priority;
  action_sets.Insert(*set, std::move(record));
  return result;
}

XrResult Instance::DestroyActionSet(XrActionSet set) {
  const XrResult result = next.DestroyActionSet(set);
  link.Beat();
  if (XR_FAILED(result)) return result;
  actions.EraseIf([set](Action& action) {
    if (action.set->handle != set) return false;
    action.destroyed = true;
    return true;
  });
  action_sets.Erase(set);
  return result;
}

XrResult Instance::CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  const XrResult result = next.CreateAction(set, info, action);
  link.Beat();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<Action>();
  record->handle = *action;
  record->set = action_sets.Find(set);
  record->type = info->actionType;
  record->subactions.assign(info->subactionPaths, info->subactionPaths + info->countSubactionPaths);
  if (record->set) actions.Insert(*action, std::move(record));
  return result;
}

XrResult Instance::DestroyAction(XrAction action) {
  const XrResult result = next.DestroyAction(action);
  link.Beat();
  if (OMNI_FAULT("space-dies-with-its-action"))
    spaces.EraseIf([action](const Space& space) { return space.action && space.action->handle == action; });
  if (XR_FAILED(result)) return result;
  if (const auto record = actions.Find(action)) record->destroyed = true;
  actions.Erase(action);
  return result;
}

XrResult Instance::Attach(XrSession session, const XrSessionActionSetsAttachInfo* info) {
  const XrResult result = next.AttachSessionActionSets(session, info);
  Alive();
  const auto record = sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  std::vector<std::shared_ptr<ActionSet>> sets;
  for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
    if (auto set = action_sets.Find(info->actionSets[i])) {
      set->attached = true;
      sets.push_back(std::move(set));
    }
  }
  Suggestions suggestions;
  {
    const std::lock_guard lock(suggestions_mutex_);
    suggestions = suggestions_;
  }
  // Actions that were destroyed since they were suggested go on working; their suggestions keep them.
  std::vector<std::shared_ptr<Action>> candidates = actions.Values();
  for (const auto& [profile, entries] : suggestions)
    for (const Suggestion& entry : entries) candidates.push_back(entry.action);
  const std::unique_lock lock(record->mutex);
  record->actions.Attach(sets, candidates, suggestions);
  return result;
}

// The runtime has validated `info`.
std::vector<ActiveSet> Instance::ActiveSets(const XrActionsSyncInfo& info) const {
  std::vector<ActiveSet> out;
  for (std::uint32_t i = 0; i < info.countActiveActionSets; ++i) {
    const XrActiveActionSet& active = info.activeActionSets[i];
    auto set = action_sets.Find(active.actionSet);
    if (!set) continue;
    const std::uint32_t priority = set->priority;
    out.push_back({std::move(set), active.subactionPath, priority});
  }
  const auto* chain = static_cast<const XrBaseInStructure*>(info.next);
  for (; chain; chain = chain->next) {
    if (chain->type != XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT || OMNI_FAULT("priority-override-ignored")) continue;
    XrActiveActionSetPrioritiesEXT overrides;
    std::memcpy(&overrides, chain, sizeof(overrides));
    for (std::uint32_t i = 0; i < overrides.actionSetPriorityCount; ++i)
      for (ActiveSet& active : out)
        if (active.set->handle == overrides.actionSetPriorities[i].actionSet)
          active.priority = overrides.actionSetPriorities[i].priorityOverride;
  }
  return out;
}

XrResult Instance::Sync(XrSession session, const XrActionsSyncInfo* info) {
  const XrResult result = next.SyncActions(session, info);
  Alive();
  const auto record = sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  const std::int64_t now = MonotonicNow_ns();
  clock.Refresh(now);
  SyncInput input;
  input.focused = result != XR_SESSION_NOT_FOCUSED || OMNI_FAULT("not-focused-is-success");
  if (record->running) SetFocus(*record, input.focused);
  input.active = ActiveSets(*info);
  input.pen = link.Read(now);

  const std::unique_lock lock(record->mutex);
  SessionActions& session_actions = record->actions;
  const Profile* before = session_actions.profile();
  session_actions.Sync(input, NextStates(next, session), clock, clock.ToXr(now));
  const Profile* after = session_actions.profile();
  UpdateSpaces(*record);
  if (before == after) return result;
  log.Line(std::string("the pen is ") + (after ? "there, as " + after->path : "gone"));
  // What the runtime shows for that hand where the pen is not.
  XrInteractionProfileState below{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  if (XR_FAILED(next.GetCurrentInteractionProfile(session, hand_path, &below))) below.interactionProfile = XR_NULL_PATH;
  const auto shown = [&](const Profile* profile) { return profile ? PathOf(profile->path) : below.interactionProfile; };
  if (record->running && (shown(before) != shown(after) || OMNI_FAULT("event-without-change")))
    record->profile_event_due = true;
  return result;
}

}  // namespace omni::layer
