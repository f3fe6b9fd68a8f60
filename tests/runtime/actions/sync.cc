// xrSyncActions: the only moment at which interaction profiles, bindings and action states change.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <span>
#include <utility>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/newer_openxr.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

// Which hands of which set this sync has made active. `all`: for XR_NULL_PATH.
struct Activation {
  bool all = false;
  bool hand[kHands] = {false, false};
  uint32_t priority = 0;
};
using Activations = std::map<const ActionSet*, Activation>;

// Highest priority of an active binding, by source identifier ("left", "input/trigger").
using Priorities = std::map<std::pair<int, std::string_view>, uint32_t>;

bool IsActive(const Activation& activation, const Action& action, const Instance& instance, int hand) {
  if (activation.all) return true;
  if (!activation.hand[hand]) return false;
  return std::any_of(action.subaction_paths.begin(), action.subaction_paths.end(),
                     [&](XrPath path) { return HandOf(instance, path) == hand; });
}

void ClearSlot(Slot& slot) {
  slot.active = slot.changed = false;
  slot.x = slot.y = 0;
  slot.change_time = 0;
  slot.pose_source = {};
}

void DeactivateActions(Session& session) {
  for (auto& [action, entry] : session.states) {
    for (Slot& slot : entry.slots) ClearSlot(slot);
  }
}

// The slot takes sources of this hand: its own subaction path, or for XR_NULL_PATH every declared one.
bool Takes(const Instance& instance, const Action& action, const Slot& slot, int hand) {
  if (slot.subaction != XR_NULL_PATH) return HandOf(instance, slot.subaction) == hand;
  if (action.subaction_paths.empty()) return true;
  return std::any_of(action.subaction_paths.begin(), action.subaction_paths.end(),
                     [&](XrPath path) { return HandOf(instance, path) == hand; });
}

void Bind(const World& world, Session& session, ActionState& entry) {
  for (Slot& slot : entry.slots) slot.bound.clear();
  for (int hand = 0; hand < kHands; ++hand) {
    const int profile = session.profile[hand];
    if (profile < 0) continue;
    for (const Suggestion& suggestion : session.suggestions.at(profile)) {
      if (suggestion.action != entry.action.get() || suggestion.hand != hand) continue;
      const int component = ResolveBinding(Profiles()[profile], hand, suggestion.path, entry.action->type);
      if (component < 0) continue;
      const Source source{hand, component, world.devices[hand].epoch};
      for (Slot& slot : entry.slots) {
        if (!Takes(*session.instance, *entry.action, slot, hand)) continue;
        const bool known = std::any_of(slot.bound.begin(), slot.bound.end(),
                                       [&source](const Bound& bound) { return bound.source == source; });
        if (!known) slot.bound.push_back({source, false, suggestion.threshold});
      }
    }
  }
}

// A device shows its own profile if that was suggested, else none. One event covers all hands.
void UpdateProfiles(const World& world, Session& session) {
  bool changed = false;
  bool rebind = false;
  for (int hand = 0; hand < kHands; ++hand) {
    const Device& device = world.devices[hand];
    const int profile = device.present && session.suggestions.contains(device.profile) ? device.profile : -1;
    changed |= profile != session.profile[hand];
    rebind |= changed || device.epoch != session.profile_epoch[hand];
    session.profile[hand] = profile;
    session.profile_epoch[hand] = device.epoch;
  }
  if (rebind) {
    for (auto& [action, entry] : session.states) Bind(world, session, entry);
  }
  if (changed && session.running) {
    Push(*session.instance, XrEventDataInteractionProfileChanged{XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED,
                                                                 nullptr, Handles::As<XrSession>(session.handle)});
  }
}

Priorities HighestPriorities(const World& world, const Session& session, const Activations& activations) {
  Priorities highest;
  for (const auto& [action, entry] : session.states) {
    const auto activation = activations.find(action->set);
    if (activation == activations.end()) continue;
    for (const Bound& bound : entry.slots.front().bound) {
      if (!IsActive(activation->second, *action, *session.instance, bound.source.hand)) continue;
      const auto identifier = SourceIdentifier(world.ComponentOf(bound.source).path);
      uint32_t& best = highest.try_emplace({bound.source.hand, identifier}, 0).first->second;
      best = std::max(best, activation->second.priority);
    }
  }
  return highest;
}

float Magnitude(XrActionType type, const Value& value) {
  return type == XR_ACTION_TYPE_VECTOR2F_INPUT ? std::hypot(value.x, value.y) : std::fabs(value.x);
}

// Analogue to boolean by threshold; the rest as it is.
Value Convert(const World& world, XrActionType type, Bound& bound) {
  Value value = world.Read(bound.source);
  if (type != XR_ACTION_TYPE_BOOLEAN_INPUT) return value;
  bound.pressed = value.x >= (bound.pressed ? bound.threshold.off : bound.threshold.on);
  value.x = bound.pressed ? 1.0f : 0.0f;
  return value;
}

// Merge of several sources (chapter "Multiple inputs"): boolean or, largest magnitude, longest vector, and for poses
// one source, kept as long as it lives, and its hand for ever.
void Evaluate(const World& world, XrActionType type, std::vector<Bound*>& sources, Slot& slot) {
  const Slot before = slot;
  ClearSlot(slot);
  if (type == XR_ACTION_TYPE_POSE_INPUT && slot.pose_hand >= 0) {
    std::erase_if(sources, [&slot](const Bound* bound) { return bound->source.hand != slot.pose_hand; });
  }
  if (sources.empty()) return;
  slot.pose_hand = sources.front()->source.hand;
  slot.active = true;
  float best = -1;
  for (Bound* const bound : sources) {
    const Value value = Convert(world, type, *bound);
    const float magnitude = Magnitude(type, value);
    if (magnitude > best) {
      best = magnitude;
      slot.x = value.x;
      slot.y = value.y;
      slot.change_time = value.change_time;
    }
  }
  slot.pose_source = sources.front()->source;
  for (const Bound* const bound : sources) {
    if (bound->source == before.pose_source) slot.pose_source = before.pose_source;
  }
  const bool same = slot.x == before.x && slot.y == before.y;
  slot.changed = before.active && !same;
  if (before.active && same) slot.change_time = before.change_time;
}

void UpdateStates(const World& world, Session& session, const Activations& activations) {
  const Priorities highest = HighestPriorities(world, session, activations);
  std::vector<Bound*> sources;
  for (auto& [action, entry] : session.states) {
    const auto activation = activations.find(action->set);
    for (Slot& slot : entry.slots) {
      sources.clear();
      for (Bound& bound : slot.bound) {
        if (activation == activations.end()) break;
        if (!IsActive(activation->second, *action, *session.instance, bound.source.hand)) continue;
        const auto identifier = SourceIdentifier(world.ComponentOf(bound.source).path);
        if (highest.at({bound.source.hand, identifier}) > activation->second.priority) continue;
        sources.push_back(&bound);
      }
      Evaluate(world, action->type, sources, slot);
    }
  }
}

XrResult CheckActiveSet(State& state, const Session& session, const XrActiveActionSet& active,
                        Activations* activations) {
  const auto set = state.handles.Share<ActionSet>(active.actionSet);
  OMNI_REQUIRE(set != nullptr, XR_ERROR_HANDLE_INVALID);
  const bool attached = std::find(session.sets.begin(), session.sets.end(), set) != session.sets.end();
  OMNI_REQUIRE(attached, XR_ERROR_ACTIONSET_NOT_ATTACHED);
  Activation& activation = (*activations)[set.get()];
  activation.priority = set->priority;
  if (active.subactionPath == XR_NULL_PATH) {
    activation.all = true;
    return XR_SUCCESS;
  }
  OMNI_REQUIRE(PathText(*session.instance, active.subactionPath) != nullptr, XR_ERROR_PATH_INVALID);
  const bool declared = std::any_of(set->actions.begin(), set->actions.end(), [&active](const auto& action) {
    const auto& paths = action->subaction_paths;
    return std::find(paths.begin(), paths.end(), active.subactionPath) != paths.end();
  });
  OMNI_REQUIRE(declared, XR_ERROR_PATH_UNSUPPORTED);
  const int hand = HandOf(*session.instance, active.subactionPath);
  if (hand >= 0) activation.hand[hand] = true;
  return XR_SUCCESS;
}

// XR_EXT_active_action_set_priority
void OverridePriorities(State& state, const Session& session, const XrActionsSyncInfo& info, Activations& activations) {
  const auto* chain = static_cast<const XrBaseInStructure*>(info.next);
  for (; chain != nullptr && session.instance->set_priorities; chain = chain->next) {
    if (chain->type != XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT) continue;
    XrActiveActionSetPrioritiesEXT overrides;
    std::memcpy(&overrides, chain, sizeof(overrides));
    for (uint32_t i = 0; i < overrides.actionSetPriorityCount; ++i) {
      const XrActiveActionSetPriorityEXT& entry = overrides.actionSetPriorities[i];
      const auto set = state.handles.Share<ActionSet>(entry.actionSet);
      const auto found = activations.find(set.get());
      if (found != activations.end()) found->second.priority = entry.priorityOverride;
    }
  }
}

}  // namespace

XrResult SyncActions(XrSession session, const XrActionsSyncInfo* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_ACTIONS_SYNC_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->countActiveActionSets == 0 || info->activeActionSets != nullptr, XR_ERROR_VALIDATION_FAILURE);
  Activations activations;
  for (uint32_t i = 0; i < info->countActiveActionSets; ++i) {
    const XrResult check = CheckActiveSet(state, *owner, info->activeActionSets[i], &activations);
    if (XR_FAILED(check)) return check;
  }
  OverridePriorities(state, *owner, *info, activations);
  RunScript(owner->instance->script, Now());
  if (const XrResult loss = Loss(*owner); XR_FAILED(loss)) return loss;
  if (owner->state != XR_SESSION_STATE_FOCUSED) {
    DeactivateActions(*owner);
    return XR_SESSION_NOT_FOCUSED;
  }
  UpdateProfiles(state.world, *owner);
  UpdateStates(state.world, *owner, activations);
  UpdateModels(state.world, *owner);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
