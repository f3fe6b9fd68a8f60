// Action sets and actions: creation, names, destruction.

#include <algorithm>
#include <cstring>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

bool IsNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
}

// Names are single path levels; localized names are any text. Neither may be empty.
template <size_t name_size, size_t localized_size>
XrResult CheckNames(const char (&name)[name_size], const char (&localized)[localized_size]) {
  OMNI_REQUIRE(std::memchr(name, 0, name_size) != nullptr, XR_ERROR_NAME_INVALID);
  OMNI_REQUIRE(std::memchr(localized, 0, localized_size) != nullptr, XR_ERROR_LOCALIZED_NAME_INVALID);
  OMNI_REQUIRE(name[0] != '\0', XR_ERROR_NAME_INVALID);
  OMNI_REQUIRE(localized[0] != '\0', XR_ERROR_LOCALIZED_NAME_INVALID);
  const std::string_view text(name);
  OMNI_REQUIRE(std::all_of(text.begin(), text.end(), IsNameCharacter), XR_ERROR_PATH_FORMAT_INVALID);
  OMNI_REQUIRE(text.find_first_not_of('.') != std::string_view::npos, XR_ERROR_PATH_FORMAT_INVALID);
  return XR_SUCCESS;
}

// Siblings: the sets of an instance, the actions of a set.
template <class Siblings>
XrResult CheckUnique(const Siblings& siblings, std::string_view name, std::string_view localized) {
  for (const auto& sibling : siblings) {
    OMNI_REQUIRE(sibling->name != name, XR_ERROR_NAME_DUPLICATED);
    OMNI_REQUIRE(sibling->localized_name != localized, XR_ERROR_LOCALIZED_NAME_DUPLICATED);
  }
  return XR_SUCCESS;
}

bool IsActionType(XrActionType type) {
  switch (type) {
    case XR_ACTION_TYPE_BOOLEAN_INPUT:
    case XR_ACTION_TYPE_FLOAT_INPUT:
    case XR_ACTION_TYPE_VECTOR2F_INPUT:
    case XR_ACTION_TYPE_POSE_INPUT:
    case XR_ACTION_TYPE_VIBRATION_OUTPUT:
      return true;
    default:
      return false;
  }
}

XrResult CheckSubactionPaths(const Instance& instance, const XrActionCreateInfo& info) {
  OMNI_REQUIRE(info.countSubactionPaths == 0 || info.subactionPaths != nullptr, XR_ERROR_VALIDATION_FAILURE);
  for (uint32_t i = 0; i < info.countSubactionPaths; ++i) {
    const std::string* const text = PathText(instance, info.subactionPaths[i]);
    OMNI_REQUIRE(text != nullptr, XR_ERROR_PATH_INVALID);
    OMNI_REQUIRE(IsTopLevelPath(*text), XR_ERROR_PATH_UNSUPPORTED);
    const XrPath* const end = info.subactionPaths + i;
    OMNI_REQUIRE(std::find(info.subactionPaths, end, info.subactionPaths[i]) == end, XR_ERROR_PATH_UNSUPPORTED);
  }
  return XR_SUCCESS;
}

}  // namespace

XrResult CreateActionSet(XrInstance instance, const XrActionSetCreateInfo* info, XrActionSet* set) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_ACTION_SET_CREATE_INFO) && set != nullptr, XR_ERROR_VALIDATION_FAILURE);
  if (const XrResult check = CheckNames(info->actionSetName, info->localizedActionSetName); XR_FAILED(check)) {
    return check;
  }
  const XrResult unique = CheckUnique(owner->action_sets, info->actionSetName, info->localizedActionSetName);
  if (XR_FAILED(unique)) return unique;
  const auto created = std::make_shared<ActionSet>();
  created->instance = owner;
  created->name = info->actionSetName;
  created->localized_name = info->localizedActionSetName;
  created->priority = info->priority;
  *set = Handles::As<XrActionSet>(state.handles.Insert(created));
  owner->action_sets.push_back(created);
  return XR_SUCCESS;
}

// The names are free again; sessions that have the set attached keep it.
XrResult DestroyActionSet(XrActionSet set) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(ActionSet, found, set);
  const auto doomed = state.handles.Share<ActionSet>(set);
  for (const auto& action : found->actions) state.handles.Erase(action->handle);
  state.handles.Erase(doomed->handle);
  std::erase(doomed->instance->action_sets, doomed);
  return XR_SUCCESS;
}

XrResult CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(ActionSet, owner, set);
  OMNI_REQUIRE(Is(info, XR_TYPE_ACTION_CREATE_INFO) && action != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(!owner->attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
  OMNI_REQUIRE(IsActionType(info->actionType), XR_ERROR_VALIDATION_FAILURE);
  if (const XrResult check = CheckNames(info->actionName, info->localizedActionName); XR_FAILED(check)) return check;
  if (const XrResult check = CheckSubactionPaths(*owner->instance, *info); XR_FAILED(check)) return check;
  const XrResult unique = CheckUnique(owner->actions, info->actionName, info->localizedActionName);
  if (XR_FAILED(unique)) return unique;
  const auto created = std::make_shared<Action>();
  created->set = owner;
  created->name = info->actionName;
  created->localized_name = info->localizedActionName;
  created->type = info->actionType;
  created->subaction_paths.assign(info->subactionPaths, info->subactionPaths + info->countSubactionPaths);
  *action = Handles::As<XrAction>(state.handles.Insert(created));
  owner->actions.push_back(created);
  return XR_SUCCESS;
}

// An attached action lives on in its session, and its spaces stay locatable.
XrResult DestroyAction(XrAction action) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Action, found, action);
  const auto doomed = state.handles.Share<Action>(action);
  state.handles.Erase(found->handle);
  // Unattached: its name is free again. Attached: the set is immutable, and the session still processes the action.
  if (!doomed->set->attached) std::erase(doomed->set->actions, doomed);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
