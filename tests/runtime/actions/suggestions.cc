// Suggested bindings, attaching, the current interaction profile.

#include <algorithm>
#include <cstring>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

XrResult CheckBinding(const Instance& instance, const Profile& profile, const XrActionSuggestedBinding& binding,
                      Suggestion* suggestion) {
  OMNI_FIND(Action, action, binding.action);
  OMNI_REQUIRE(action->set->instance == &instance, XR_ERROR_VALIDATION_FAILURE);
  const std::string* const text = PathText(instance, binding.binding);
  OMNI_REQUIRE(text != nullptr, XR_ERROR_PATH_INVALID);
  const HandPath split = SplitHandPath(*text);
  OMNI_REQUIRE(split.hand >= 0 && IsSupported(profile, split.hand, split.rest), XR_ERROR_PATH_UNSUPPORTED);
  // OpenXR 1.1 has it in every profile.
  OMNI_REQUIRE(instance.version_1_1 || !split.rest.starts_with("input/grip_surface"), XR_ERROR_PATH_UNSUPPORTED);
  OMNI_REQUIRE(!action->set->attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
  *suggestion = {action, split.hand, std::string(split.rest), {}};
  return XR_SUCCESS;
}

// XR_VALVE_analog_threshold, chained or in XrBindingModificationsKHR.
XrResult ApplyThreshold(const XrInteractionProfileSuggestedBinding& info,
                        const XrBindingModificationBaseHeaderKHR* header, std::vector<Suggestion>& suggestions) {
  OMNI_REQUIRE(header != nullptr, XR_ERROR_VALIDATION_FAILURE);
  if (header->type != XR_TYPE_INTERACTION_PROFILE_ANALOG_THRESHOLD_VALVE) return XR_SUCCESS;
  XrInteractionProfileAnalogThresholdVALVE asked;
  std::memcpy(&asked, header, sizeof(asked));
  const bool in_range = asked.offThreshold >= 0 && asked.onThreshold <= 1 && asked.onThreshold >= asked.offThreshold;
  OMNI_REQUIRE(in_range, XR_ERROR_VALIDATION_FAILURE);
  bool found = false;
  for (uint32_t i = 0; i < info.countSuggestedBindings; ++i) {
    const XrActionSuggestedBinding& binding = info.suggestedBindings[i];
    if (binding.action != asked.action || binding.binding != asked.binding) continue;
    suggestions[i].threshold = {asked.onThreshold, asked.offThreshold};
    found = true;
  }
  OMNI_REQUIRE(found, XR_ERROR_PATH_UNSUPPORTED);
  return XR_SUCCESS;
}

XrResult ApplyModifications(const Instance& instance, const XrInteractionProfileSuggestedBinding& info,
                            std::vector<Suggestion>& suggestions) {
  if (!instance.analog_threshold) return XR_SUCCESS;
  const auto* chain = static_cast<const XrBaseInStructure*>(info.next);
  for (; chain != nullptr; chain = chain->next) {
    if (chain->type == XR_TYPE_INTERACTION_PROFILE_ANALOG_THRESHOLD_VALVE) {
      const auto* header = static_cast<const XrBindingModificationBaseHeaderKHR*>(static_cast<const void*>(chain));
      const XrResult applied = ApplyThreshold(info, header, suggestions);
      if (XR_FAILED(applied)) return applied;
    }
    if (chain->type != XR_TYPE_BINDING_MODIFICATIONS_KHR || !instance.binding_modification) continue;
    XrBindingModificationsKHR modifications;
    std::memcpy(&modifications, chain, sizeof(modifications));
    OMNI_REQUIRE(modifications.bindingModificationCount == 0 || modifications.bindingModifications != nullptr,
                 XR_ERROR_VALIDATION_FAILURE);
    for (uint32_t i = 0; i < modifications.bindingModificationCount; ++i) {
      const XrResult applied = ApplyThreshold(info, modifications.bindingModifications[i], suggestions);
      if (XR_FAILED(applied)) return applied;
    }
  }
  return XR_SUCCESS;
}

void AddStates(Session& session, const ActionSet& set) {
  for (const auto& action : set.actions) {
    ActionState entry;
    entry.action = action;
    entry.slots.resize(1 + action->subaction_paths.size());
    for (size_t i = 0; i < action->subaction_paths.size(); ++i) {
      entry.slots[i + 1].subaction = action->subaction_paths[i];
    }
    session.states.emplace(action.get(), std::move(entry));
  }
}

}  // namespace

// All bindings are checked before any is recorded; a second suggestion for a profile replaces the first.
XrResult SuggestInteractionProfileBindings(XrInstance instance, const XrInteractionProfileSuggestedBinding* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->countSuggestedBindings > 0 && info->suggestedBindings != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const std::string* const text = PathText(*owner, info->interactionProfile);
  OMNI_REQUIRE(text != nullptr, XR_ERROR_PATH_INVALID);
  const int profile = FindProfile(*text);
  OMNI_REQUIRE(profile >= 0, XR_ERROR_PATH_UNSUPPORTED);
  std::vector<Suggestion> suggestions(info->countSuggestedBindings);
  for (uint32_t i = 0; i < info->countSuggestedBindings; ++i) {
    const XrResult check = CheckBinding(*owner, Profiles()[profile], info->suggestedBindings[i], &suggestions[i]);
    if (XR_FAILED(check)) return check;
  }
  const XrResult modified = ApplyModifications(*owner, *info, suggestions);
  if (XR_FAILED(modified)) return modified;
  owner->suggestions[profile] = std::move(suggestions);
  return XR_SUCCESS;
}

XrResult AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->countActionSets > 0 && info->actionSets != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(!owner->attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
  std::vector<std::shared_ptr<ActionSet>> sets;
  for (uint32_t i = 0; i < info->countActionSets; ++i) {
    OMNI_FIND(ActionSet, set, info->actionSets[i]);
    OMNI_REQUIRE(set->instance == owner->instance, XR_ERROR_VALIDATION_FAILURE);
    sets.push_back(state.handles.Share<ActionSet>(info->actionSets[i]));
  }
  for (const auto& set : sets) {
    set->attached = true;
    AddStates(*owner, *set);
  }
  owner->sets = std::move(sets);
  owner->suggestions = owner->instance->suggestions;
  owner->attached = true;
  return XR_SUCCESS;
}

XrResult GetCurrentInteractionProfile(XrSession session, XrPath top_level_path, XrInteractionProfileState* profile) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(profile, XR_TYPE_INTERACTION_PROFILE_STATE), XR_ERROR_VALIDATION_FAILURE);
  const std::string* const text = PathText(*owner->instance, top_level_path);
  OMNI_REQUIRE(text != nullptr, XR_ERROR_PATH_INVALID);
  OMNI_REQUIRE(IsTopLevelPath(*text), XR_ERROR_PATH_UNSUPPORTED);
  OMNI_REQUIRE(owner->attached, XR_ERROR_ACTIONSET_NOT_ATTACHED);
  const int hand = HandOf(*owner->instance, top_level_path);
  const int current = hand < 0 ? -1 : owner->profile[hand];
  profile->interactionProfile = current < 0 ? XR_NULL_PATH : InternPath(*owner->instance, Profiles()[current].path);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
