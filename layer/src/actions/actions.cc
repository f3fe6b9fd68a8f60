// Action sets, actions, attachment and the sync, the only place where their state changes.
#include <cstring>
#include <string>

#include "layer/src/instance/instance.h"
#include "service/base/clock.h"

namespace omni::layer {
namespace {

// The runtime's part of each action, through its own queries.
class NextStates : public RuntimeStates {
 public:
  NextStates(const Dispatch& next, XrSession session) : next_(next), session_(session) {}

  StatePart Query(const Action& action, XrPath subaction) const override {
    if (action.destroyed) return {};
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
  const auto record = actions.Find(action);
  const XrResult result = next.DestroyAction(action);
  link.Beat();
  if (XR_FAILED(result)) return result;
  if (record) record->destroyed = true;
  if (record && !record->set->attached) record->withdrawn = true;
  actions.Erase(action);
  return result;
}

XrResult Instance::AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info) {
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
  // Actions that were destroyed since they were suggested keep working; their suggestions keep them alive.
  std::vector<std::shared_ptr<Action>> candidates = actions.Values();
  for (const auto& [profile, entries] : suggestions)
    for (const Suggestion& entry : entries)
      if (!entry.action->withdrawn) candidates.push_back(entry.action);
  const std::unique_lock lock(record->mutex);
  record->actions.Attach(sets, candidates, suggestions);
  if (record->actions.preference_unusable())
    log.Line("the preferred profile has no suggested binding that the pen serves; using the best of the others");
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
    if (chain->type != XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT) continue;
    XrActiveActionSetPrioritiesEXT overrides;
    std::memcpy(&overrides, chain, sizeof(overrides));
    for (std::uint32_t i = 0; i < overrides.actionSetPriorityCount; ++i)
      for (ActiveSet& active : out)
        if (active.set->handle == overrides.actionSetPriorities[i].actionSet)
          active.priority = overrides.actionSetPriorities[i].priorityOverride;
  }
  return out;
}

XrPath Instance::ProfileBelow(XrSession session, XrPath user_path) const {
  XrInteractionProfileState below{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  const XrResult result = next.GetCurrentInteractionProfile(session, user_path, &below);
  return XR_SUCCEEDED(result) ? below.interactionProfile : XR_NULL_PATH;
}

// A pen that was put down yields its hand to the runtime's controller, if the runtime has one for that hand.
bool Instance::PutDown(Session& session, const PenSnapshot& pen) {
  if (!pen.present) {
    session.rest.Reset();
    return false;
  }
  RestLimits limits;
  const float wished_s = link.settings().rest_after_s;
  if (wished_s > 0) limits.still_ns = static_cast<std::int64_t>(1e9 * static_cast<double>(wished_s));
  if (wished_s < 0) limits.still_ns = 0;
  return session.rest.Update(pen, limits) && ProfileBelow(session.handle, session.actions.hand_path()) != XR_NULL_PATH;
}

// The runtime reports its own changes; we report the pen's, if they change the profile that the application sees.
// `before` and `after` differ.
void Instance::NotifyProfileChange(Session& session, XrPath user_path, const Profile* before, const Profile* after) {
  if (!session.running) return;
  const XrPath below = before && after ? XR_NULL_PATH : ProfileBelow(session.handle, user_path);
  const auto shown = [&](const Profile* profile) { return profile ? PathOf(profile->path) : below; };
  if (shown(before) != shown(after)) session.profile_event_due = true;
}

XrResult Instance::SyncActions(XrSession session, const XrActionsSyncInfo* info) {
  const XrResult result = next.SyncActions(session, info);
  Alive();
  const auto record = sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  const std::int64_t now = base::MonotonicNow_ns();
  clock.Refresh(now);
  SyncInput input;
  input.focused = result != XR_SESSION_NOT_FOCUSED;
  if (record->running) SetFocus(*record, input.focused);
  input.active = ActiveSets(*info);
  input.choice = Choice();
  input.pen = link.Read(now);
  input.start_edges = record->focus_was_lost.exchange(false);
  TestInputs test;
  if (link.test() && link.test()->in_control()) {
    test = link.test()->inputs();
    input.test = &test;
    input.choice.profile = test.profile;
  }
  FollowConstraints();
  WatchForces();

  const std::unique_lock lock(record->mutex);
  input.put_down = !input.test && PutDown(*record, input.pen);
  SessionActions& state = record->actions;
  const Profile* before[] = {state.ProfileAt(hand_paths[0]), state.ProfileAt(hand_paths[1])};
  state.Sync(input, NextStates(next, session), clock, clock.ToXr(now));
  UpdateSpaces(*record);
  for (const Pulse& pulse : state.PopPulses()) Play(pulse);
  for (std::size_t hand = 0; hand < hand_paths.size(); ++hand) {
    const Profile* after = state.ProfileAt(hand_paths[hand]);
    if (before[hand] == after) continue;
    const std::string side(UserPath(static_cast<Hand>(hand)));
    log.Line(side + (after ? ": the pen, as " + after->path : ": the pen is gone or put down"));
    NotifyProfileChange(*record, hand_paths[hand], before[hand], after);
  }
  return result;
}

}  // namespace omni::layer
