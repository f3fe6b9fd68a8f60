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

XrResult Input::CreateActionSet(const XrActionSetCreateInfo* info, XrActionSet* set) {
  const XrResult result = instance_.next.CreateActionSet(instance_.handle, info, set);
  instance_.link.Beat();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<ActionSet>();
  record->handle = *set;
  record->priority = info->priority;
  instance_.action_sets.Insert(*set, std::move(record));
  return result;
}

XrResult Input::DestroyActionSet(XrActionSet set) {
  const XrResult result = instance_.next.DestroyActionSet(set);
  instance_.link.Beat();
  if (XR_FAILED(result)) return result;
  instance_.actions.EraseIf([set](Action& action) {
    if (action.set->handle != set) return false;
    action.destroyed = true;
    return true;
  });
  instance_.action_sets.Erase(set);
  return result;
}

XrResult Input::CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  const XrResult result = instance_.next.CreateAction(set, info, action);
  instance_.link.Beat();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<Action>();
  record->handle = *action;
  record->set = instance_.action_sets.Find(set);
  record->type = info->actionType;
  record->subactions.assign(info->subactionPaths, info->subactionPaths + info->countSubactionPaths);
  if (record->set) instance_.actions.Insert(*action, std::move(record));
  return result;
}

XrResult Input::DestroyAction(XrAction action) {
  const auto record = instance_.actions.Find(action);
  const XrResult result = instance_.next.DestroyAction(action);
  instance_.link.Beat();
  if (XR_FAILED(result)) return result;
  if (record) record->destroyed = true;
  if (record && !record->set->attached) record->withdrawn = true;
  instance_.actions.Erase(action);
  return result;
}

XrResult Input::AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info) {
  const XrResult result = instance_.next.AttachSessionActionSets(session, info);
  instance_.Alive();
  const auto record = instance_.sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  std::vector<std::shared_ptr<ActionSet>> sets;
  for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
    if (auto set = instance_.action_sets.Find(info->actionSets[i])) {
      set->attached = true;
      sets.push_back(std::move(set));
    }
  }
  const Suggestions suggestions = instance_.bindings.Suggested();
  // Actions that were destroyed since they were suggested keep working; their suggestions keep them alive.
  std::vector<std::shared_ptr<Action>> candidates = instance_.actions.Values();
  for (const auto& [profile, entries] : suggestions)
    for (const Suggestion& entry : entries)
      if (!entry.action->withdrawn) candidates.push_back(entry.action);
  const std::unique_lock lock(record->mutex);
  record->actions.Attach(sets, candidates, suggestions);
  if (record->actions.preference_unusable())
    instance_.log.Line(
        "the preferred profile has no suggested binding that the pen serves; using the best of the others");
  return result;
}

// The runtime has validated `info`.
std::vector<ActiveSet> Input::ActiveSets(const XrActionsSyncInfo& info) const {
  std::vector<ActiveSet> out;
  for (std::uint32_t i = 0; i < info.countActiveActionSets; ++i) {
    const XrActiveActionSet& active = info.activeActionSets[i];
    auto set = instance_.action_sets.Find(active.actionSet);
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

// A pen that was put down yields its hand to the runtime's controller, if the runtime has one for that hand.
bool Input::PutDown(Session& session, const PenSnapshot& pen) {
  if (!pen.present) {
    session.rest.Reset();
    return false;
  }
  RestLimits limits;
  const float wished_s = instance_.link.settings().rest_after_s;
  if (wished_s > 0) limits.still_ns = static_cast<std::int64_t>(1e9 * static_cast<double>(wished_s));
  if (wished_s < 0) limits.still_ns = 0;
  return session.rest.Update(pen, limits) &&
         instance_.bindings.ProfileBelow(session.handle, session.actions.hand_path()) != XR_NULL_PATH;
}

XrResult Input::SyncActions(XrSession session, const XrActionsSyncInfo* info) {
  const XrResult result = instance_.next.SyncActions(session, info);
  instance_.Alive();
  const auto record = instance_.sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  Sync(*record, *info, result != XR_SESSION_NOT_FOCUSED);
  instance_.render_models.Follow(record);
  return result;
}

// The runtime has synced.
void Input::Sync(Session& session, const XrActionsSyncInfo& info, bool focused) {
  const std::int64_t now = base::MonotonicNow_ns();
  instance_.clock.Refresh(now);
  SyncInput input;
  input.focused = focused;
  if (session.running) instance_.SetFocus(session, input.focused);
  input.active = ActiveSets(info);
  input.choice = instance_.Choice();
  input.start_edges = session.focus_was_lost.exchange(false);
  TestInputs test;
  if (instance_.link.test() && instance_.link.test()->in_control()) {
    test = instance_.link.test()->inputs();
    input.test = &test;
    input.choice.profile = test.profile;
  }
  instance_.force_feedbacks.FollowConstraints();
  instance_.force_feedbacks.Watch();

  const std::unique_lock lock(session.mutex);
  input.pen = session.pen = instance_.link.Read(now, session.pen);
  input.put_down = !input.test && PutDown(session, input.pen);
  SessionActions& state = session.actions;
  const Profile* before[] = {state.ProfileAt(instance_.hand_paths[0]), state.ProfileAt(instance_.hand_paths[1])};
  state.Sync(input, NextStates(instance_.next, session.handle), instance_.clock, instance_.clock.ToXr(now));
  instance_.locator.UpdateSpaces(session);
  for (const Pulse& pulse : state.PopPulses()) instance_.vibrations.Play(pulse);
  for (std::size_t hand = 0; hand < instance_.hand_paths.size(); ++hand) {
    const Profile* after = state.ProfileAt(instance_.hand_paths[hand]);
    if (before[hand] == after) continue;
    const std::string side(UserPath(static_cast<Hand>(hand)));
    instance_.log.Line(side + (after ? ": the pen, as " + after->path : ": the pen is gone or put down"));
    instance_.bindings.NotifyProfileChange(session, instance_.hand_paths[hand], before[hand], after);
  }
}

}  // namespace omni::layer
