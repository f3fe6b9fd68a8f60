// Reading action states and their sources: what the last xrSyncActions left.

#include <algorithm>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

// The checks that all state queries share.
XrResult Query(XrSession session, const XrActionStateGetInfo* info, XrActionType type, const Slot** slot) {
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_ACTION_STATE_GET_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(Action, action, info->action);
  OMNI_REQUIRE(action->type == type, XR_ERROR_ACTION_TYPE_MISMATCH);
  Slot* found = nullptr;
  const XrResult result = FindSlot(*owner, *action, info->subactionPath, &found);
  *slot = found;
  return result;
}

constexpr XrInputSourceLocalizedNameFlags kNameFlags = XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT |
                                                       XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT |
                                                       XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT;

void AppendWord(std::string& text, std::string_view word) {
  if (!text.empty()) text += ' ';
  text += word;
}

}  // namespace

XrResult FindSlot(Session& session, const Action& action, XrPath subaction, Slot** slot) {
  const auto& declared = action.subaction_paths;
  size_t index = 0;
  if (subaction != XR_NULL_PATH) {
    OMNI_REQUIRE(PathText(*session.instance, subaction) != nullptr, XR_ERROR_PATH_INVALID);
    const auto found = std::find(declared.begin(), declared.end(), subaction);
    OMNI_REQUIRE(found != declared.end(), XR_ERROR_PATH_UNSUPPORTED);
    index = static_cast<size_t>(found - declared.begin()) + 1;
  }
  const auto entry = session.states.find(&action);
  OMNI_REQUIRE(entry != session.states.end(), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  *slot = &entry->second.slots[index];
  return XR_SUCCESS;
}

XrResult GetActionStateBoolean(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* out) {
  const std::shared_lock lock(TheState().mutex);
  const Slot* slot = nullptr;
  if (const XrResult check = Query(session, info, XR_ACTION_TYPE_BOOLEAN_INPUT, &slot); XR_FAILED(check)) return check;
  OMNI_REQUIRE(Is(out, XR_TYPE_ACTION_STATE_BOOLEAN), XR_ERROR_VALIDATION_FAILURE);
  out->currentState = slot->x > 0.5f;
  out->changedSinceLastSync = slot->changed;
  out->lastChangeTime = slot->change_time;
  out->isActive = slot->active;
  return XR_SUCCESS;
}

XrResult GetActionStateFloat(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* out) {
  const std::shared_lock lock(TheState().mutex);
  const Slot* slot = nullptr;
  if (const XrResult check = Query(session, info, XR_ACTION_TYPE_FLOAT_INPUT, &slot); XR_FAILED(check)) return check;
  OMNI_REQUIRE(Is(out, XR_TYPE_ACTION_STATE_FLOAT), XR_ERROR_VALIDATION_FAILURE);
  out->currentState = slot->x;
  out->changedSinceLastSync = slot->changed;
  out->lastChangeTime = slot->change_time;
  out->isActive = slot->active;
  return XR_SUCCESS;
}

XrResult GetActionStateVector2f(XrSession session, const XrActionStateGetInfo* info, XrActionStateVector2f* out) {
  const std::shared_lock lock(TheState().mutex);
  const Slot* slot = nullptr;
  if (const XrResult check = Query(session, info, XR_ACTION_TYPE_VECTOR2F_INPUT, &slot); XR_FAILED(check)) return check;
  OMNI_REQUIRE(Is(out, XR_TYPE_ACTION_STATE_VECTOR2F), XR_ERROR_VALIDATION_FAILURE);
  out->currentState = {slot->x, slot->y};
  out->changedSinceLastSync = slot->changed;
  out->lastChangeTime = slot->change_time;
  out->isActive = slot->active;
  return XR_SUCCESS;
}

XrResult GetActionStatePose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* out) {
  const std::shared_lock lock(TheState().mutex);
  const Slot* slot = nullptr;
  if (const XrResult check = Query(session, info, XR_ACTION_TYPE_POSE_INPUT, &slot); XR_FAILED(check)) return check;
  OMNI_REQUIRE(Is(out, XR_TYPE_ACTION_STATE_POSE), XR_ERROR_VALIDATION_FAILURE);
  out->isActive = slot->active;
  return XR_SUCCESS;
}

XrResult EnumerateBoundSourcesForAction(XrSession session, const XrBoundSourcesForActionEnumerateInfo* info,
                                        uint32_t capacity, uint32_t* count, XrPath* sources) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(Action, action, info->action);
  Slot* slot = nullptr;
  if (const XrResult check = FindSlot(*owner, *action, XR_NULL_PATH, &slot); XR_FAILED(check)) return check;
  std::vector<XrPath> paths;
  for (const Bound& bound : slot->bound) {
    if (bound.source.epoch != state.world.devices[bound.source.hand].epoch) continue;
    const std::string hand(kHandPaths[bound.source.hand]);
    paths.push_back(InternPath(*owner->instance, hand + "/" + std::string(state.world.ComponentOf(bound.source).path)));
  }
  return TwoCall(static_cast<uint32_t>(paths.size()), capacity, count, sources,
                 [&paths](uint32_t i, XrPath& out) { out = paths[i]; });
}

XrResult GetInputSourceLocalizedName(XrSession session, const XrInputSourceLocalizedNameGetInfo* info,
                                     uint32_t capacity, uint32_t* count, char* buffer) {
  const std::shared_lock lock(TheState().mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO), XR_ERROR_VALIDATION_FAILURE);
  const bool flags_ok = info->whichComponents != 0 && (info->whichComponents & ~kNameFlags) == 0;
  OMNI_REQUIRE(flags_ok, XR_ERROR_VALIDATION_FAILURE);
  const std::string* const text = PathText(*owner->instance, info->sourcePath);
  OMNI_REQUIRE(text != nullptr, XR_ERROR_PATH_INVALID);
  OMNI_REQUIRE(owner->attached, XR_ERROR_ACTIONSET_NOT_ATTACHED);
  const HandPath split = SplitHandPath(*text);
  const int current = split.hand < 0 ? -1 : owner->profile[split.hand];
  OMNI_REQUIRE(current >= 0, XR_ERROR_PATH_UNSUPPORTED);
  const Profile& profile = Profiles()[current];
  const int component = FindComponent(profile, split.hand, split.rest);
  OMNI_REQUIRE(component >= 0, XR_ERROR_PATH_UNSUPPORTED);
  std::string name;
  if ((info->whichComponents & XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT) != 0) {
    AppendWord(name, split.hand == 0 ? "Left Hand" : "Right Hand");
  }
  if ((info->whichComponents & XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT) != 0) {
    AppendWord(name, profile.name);
  }
  if ((info->whichComponents & XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT) != 0) {
    AppendWord(name, profile.components[component].name);
  }
  return TwoCallString(name, capacity, count, buffer);
}

}  // namespace omni::runtime
