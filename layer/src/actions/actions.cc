// Action sets, actions, attachment and the sync, the only place where their state changes.
#include <cstring>
#include <string>

#include "layer/src/actions/input.h"
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
  const XrResult result = runtime_.next.CreateActionSet(runtime_.handle, info, set);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<ActionSet>();
  record->handle = *set;
  record->priority = info->priority;
  records_.action_sets.Insert(*set, std::move(record));
  return result;
}

XrResult Input::DestroyActionSet(XrActionSet set) {
  const XrResult result = runtime_.next.DestroyActionSet(set);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  records_.actions.EraseIf([set](Action& action) {
    if (action.set->handle != set) return false;
    action.destroyed = true;
    return true;
  });
  records_.action_sets.Erase(set);
  return result;
}

XrResult Input::CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  const XrResult result = runtime_.next.CreateAction(set, info, action);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  auto record = std::make_shared<Action>();
  record->handle = *action;
  record->set = records_.action_sets.Find(set);
  record->type = info->actionType;
  record->subactions.assign(info->subactionPaths, info->subactionPaths + info->countSubactionPaths);
  if (record->set) records_.actions.Insert(*action, std::move(record));
  return result;
}

XrResult Input::DestroyAction(XrAction action) {
  const auto record = records_.actions.Find(action);
  const XrResult result = runtime_.next.DestroyAction(action);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  if (record) record->destroyed = true;
  if (record && !record->set->attached) record->withdrawn = true;
  records_.actions.Erase(action);
  return result;
}

XrResult Input::AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info) {
  const XrResult result = runtime_.next.AttachSessionActionSets(session, info);
  link_.SignalAlive();
  link_.Poll(base::MonotonicNow_ns());
  const auto record = records_.sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  std::vector<std::shared_ptr<ActionSet>> sets;
  for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
    if (auto set = records_.action_sets.Find(info->actionSets[i])) {
      set->attached = true;
      sets.push_back(std::move(set));
    }
  }
  const Suggestions suggestions = bindings_.Suggested();
  // Actions that were destroyed since they were suggested keep working; their suggestions keep them alive.
  std::vector<std::shared_ptr<Action>> candidates = records_.actions.Values();
  for (const auto& [profile, entries] : suggestions)
    for (const Suggestion& entry : entries)
      if (!entry.action->withdrawn) candidates.push_back(entry.action);
  const std::unique_lock lock(record->mutex);
  record->actions.Attach(sets, candidates, suggestions);
  if (record->actions.preference_unusable())
    log_.WriteLine("the preferred profile has no suggested binding that the pen serves; using the best of the others");
  return result;
}

// The runtime has validated `info`.
std::vector<ActiveSet> Input::ActiveSets(const XrActionsSyncInfo& info) const {
  std::vector<ActiveSet> out;
  for (std::uint32_t i = 0; i < info.countActiveActionSets; ++i) {
    const XrActiveActionSet& active = info.activeActionSets[i];
    auto set = records_.action_sets.Find(active.actionSet);
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
  const float wished_s = link_.settings().rest_after_s;
  if (wished_s > 0) limits.still_ns = static_cast<std::int64_t>(1e9 * static_cast<double>(wished_s));
  if (wished_s < 0) limits.still_ns = 0;
  return session.rest.Update(pen, limits) &&
         bindings_.ProfileBelow(session.handle, session.actions.hand_path()) != XR_NULL_PATH;
}

void Input::Sync(Session& session, const XrActionsSyncInfo& info, bool focused, std::int64_t now_ns) {
  SyncInput input;
  input.focused = focused;
  input.active = ActiveSets(info);
  input.choice = link_.choice();
  input.start_edges = session.focus_was_lost.exchange(false);
  TestInputs test;
  if (link_.test() && link_.test()->in_control()) {
    test = link_.test()->inputs();
    input.test = &test;
    input.choice.profile = test.profile;
  }

  const std::unique_lock lock(session.mutex);
  input.pen = session.pen = link_.ReadPen(now_ns, session.pen);
  input.put_down = !input.test && PutDown(session, input.pen);
  SessionActions& state = session.actions;
  const Profile* before[] = {state.ProfileAt(runtime_.hand_paths[0]), state.ProfileAt(runtime_.hand_paths[1])};
  state.Sync(input, NextStates(runtime_.next, session.handle), clock_, clock_.ToXr(now_ns));
  records_.spaces.ForEach([&](Space& space) {
    if (space.action && space.session.get() == &session) state.UpdateServedBy(space);
  });
  for (const Pulse& pulse : state.PopPulses()) vibrations_.Play(pulse);
  for (std::size_t hand = 0; hand < runtime_.hand_paths.size(); ++hand) {
    const Profile* after = state.ProfileAt(runtime_.hand_paths[hand]);
    if (before[hand] == after) continue;
    const std::string side(UserPath(static_cast<Hand>(hand)));
    log_.WriteLine(side + (after ? ": the pen, as " + after->path : ": the pen is gone or put down"));
    bindings_.NotifyProfileChange(session, runtime_.hand_paths[hand], before[hand], after);
  }
}

}  // namespace omni::layer
