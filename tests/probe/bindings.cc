#include "tests/probe/bindings.h"

#include <cstdio>

namespace probe {
namespace {

// A boolean action may be bound to an analogue input: the runtime applies the threshold.
const ProfileBindings kProfiles[] = {
    {"mx_ink",
     "/interaction_profiles/logitech/mx_ink_stylus_logitech",
     "XR_LOGITECH_mx_ink_stylus_interaction",
     {{&Actions::grip, "/input/grip/pose"},
      {&Actions::aim, "/input/aim/pose"},
      {&Actions::tip, "/input/tip_logitech/pose"},
      {&Actions::select, "/input/tip_logitech/force"},
      {&Actions::force, "/input/tip_logitech/force"},
      {&Actions::haptic, "/output/haptic"}}},
    {"touch",
     "/interaction_profiles/oculus/touch_controller",
     nullptr,
     {{&Actions::grip, "/input/grip/pose"},
      {&Actions::aim, "/input/aim/pose"},
      {&Actions::select, "/input/trigger/value"},
      {&Actions::force, "/input/trigger/value"},
      {&Actions::thumbstick, "/input/thumbstick"},
      {&Actions::haptic, "/output/haptic"}}},
    {"simple",
     "/interaction_profiles/khr/simple_controller",
     nullptr,
     {{&Actions::grip, "/input/grip/pose"},
      {&Actions::aim, "/input/aim/pose"},
      {&Actions::select, "/input/select/click"},
      {&Actions::force, "/input/select/click"},
      {&Actions::haptic, "/output/haptic"}}},
};

struct ActionRow {
  XrAction Actions::*action;
  XrActionType type;
  const char* name;
  const char* localized_name;
};
constexpr ActionRow kActions[] = {
    {&Actions::grip, XR_ACTION_TYPE_POSE_INPUT, "grip", "Grip"},
    {&Actions::aim, XR_ACTION_TYPE_POSE_INPUT, "aim", "Aim"},
    {&Actions::tip, XR_ACTION_TYPE_POSE_INPUT, "tip", "Tip"},
    {&Actions::select, XR_ACTION_TYPE_BOOLEAN_INPUT, "select", "Select"},
    {&Actions::force, XR_ACTION_TYPE_FLOAT_INPUT, "force", "Force"},
    {&Actions::thumbstick, XR_ACTION_TYPE_VECTOR2F_INPUT, "thumbstick", "Thumbstick"},
    {&Actions::haptic, XR_ACTION_TYPE_VIBRATION_OUTPUT, "haptic", "Haptic"},
};

}  // namespace

const ProfileBindings* FindProfile(const std::string& name) {
  for (const ProfileBindings& profile : kProfiles) {
    if (name == profile.name) return &profile;
  }
  return nullptr;
}

XrResult CreateActions(XrInstance instance, XrPath hand, Actions* actions, const char** failed_call) {
  XrActionSetCreateInfo set_info{};
  set_info.type = XR_TYPE_ACTION_SET_CREATE_INFO;
  std::snprintf(set_info.actionSetName, sizeof(set_info.actionSetName), "touch");
  std::snprintf(set_info.localizedActionSetName, sizeof(set_info.localizedActionSetName), "Touch");
  *failed_call = "xrCreateActionSet";
  XrResult result = xrCreateActionSet(instance, &set_info, &actions->set);
  *failed_call = "xrCreateAction";
  for (const ActionRow& row : kActions) {
    if (XR_FAILED(result)) break;
    XrActionCreateInfo info{};
    info.type = XR_TYPE_ACTION_CREATE_INFO;
    info.actionType = row.type;
    info.countSubactionPaths = 1;
    info.subactionPaths = &hand;
    std::snprintf(info.actionName, sizeof(info.actionName), "%s", row.name);
    std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "%s", row.localized_name);
    result = xrCreateAction(actions->set, &info, &(actions->*row.action));
  }
  return result;
}

XrResult Suggest(XrInstance instance, const std::string& hand_path, const ProfileBindings& profile,
                 const Actions& actions) {
  std::vector<XrActionSuggestedBinding> bindings;
  for (const Binding& binding : profile.bindings) {
    XrPath path = XR_NULL_PATH;
    const XrResult result = xrStringToPath(instance, (hand_path + binding.path).c_str(), &path);
    if (XR_FAILED(result)) return result;
    bindings.push_back({actions.*binding.action, path});
  }
  XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING};
  const XrResult result = xrStringToPath(instance, profile.path, &info.interactionProfile);
  if (XR_FAILED(result)) return result;
  info.countSuggestedBindings = static_cast<uint32_t>(bindings.size());
  info.suggestedBindings = bindings.data();
  return xrSuggestInteractionProfileBindings(instance, &info);
}

}  // namespace probe
