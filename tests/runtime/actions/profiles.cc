#include "tests/runtime/actions/profiles.h"

#include <array>
#include <string>

namespace omni::runtime {
namespace {

using enum ComponentType;

constexpr Component kSimple[] = {
    {"input/select/click", kBool, kBoth, "Select"}, {"input/menu/click", kBool, kBoth, "Menu"},
    {"input/grip/pose", kPose, kBoth, "Grip"},      {"input/grip_surface/pose", kPose, kBoth, "Grip surface"},
    {"input/aim/pose", kPose, kBoth, "Aim"},        {"output/haptic", kHaptic, kBoth, "Haptics"},
};

constexpr Component kTouch[] = {
    {"input/x/click", kBool, kLeft, "X"},
    {"input/x/touch", kBool, kLeft, "X"},
    {"input/y/click", kBool, kLeft, "Y"},
    {"input/y/touch", kBool, kLeft, "Y"},
    {"input/menu/click", kBool, kLeft, "Menu"},
    {"input/a/click", kBool, kRight, "A"},
    {"input/a/touch", kBool, kRight, "A"},
    {"input/b/click", kBool, kRight, "B"},
    {"input/b/touch", kBool, kRight, "B"},
    {"input/system/click", kBool, kRight, "System"},
    {"input/squeeze/value", kFloat, kBoth, "Squeeze"},
    {"input/trigger/value", kFloat, kBoth, "Trigger"},
    {"input/trigger/touch", kBool, kBoth, "Trigger"},
    {"input/thumbstick", kVector2, kBoth, "Thumbstick"},
    {"input/thumbstick/x", kVectorX, kBoth, "Thumbstick"},
    {"input/thumbstick/y", kVectorY, kBoth, "Thumbstick"},
    {"input/thumbstick/click", kBool, kBoth, "Thumbstick"},
    {"input/thumbstick/touch", kBool, kBoth, "Thumbstick"},
    {"input/thumbrest/touch", kBool, kBoth, "Thumbrest"},
    {"input/grip/pose", kPose, kBoth, "Grip"},
    {"input/grip_surface/pose", kPose, kBoth, "Grip surface"},
    {"input/aim/pose", kPose, kBoth, "Aim"},
    {"output/haptic", kHaptic, kBoth, "Haptics"},
};

constexpr Component kIndex[] = {
    {"input/system/click", kBool, kBoth, "System"},
    {"input/system/touch", kBool, kBoth, "System"},
    {"input/a/click", kBool, kBoth, "A"},
    {"input/a/touch", kBool, kBoth, "A"},
    {"input/b/click", kBool, kBoth, "B"},
    {"input/b/touch", kBool, kBoth, "B"},
    {"input/squeeze/value", kFloat, kBoth, "Squeeze"},
    {"input/squeeze/force", kFloat, kBoth, "Squeeze"},
    {"input/trigger/click", kBool, kBoth, "Trigger"},
    {"input/trigger/value", kFloat, kBoth, "Trigger"},
    {"input/trigger/touch", kBool, kBoth, "Trigger"},
    {"input/thumbstick", kVector2, kBoth, "Thumbstick"},
    {"input/thumbstick/x", kVectorX, kBoth, "Thumbstick"},
    {"input/thumbstick/y", kVectorY, kBoth, "Thumbstick"},
    {"input/thumbstick/click", kBool, kBoth, "Thumbstick"},
    {"input/thumbstick/touch", kBool, kBoth, "Thumbstick"},
    {"input/trackpad", kVector2, kBoth, "Trackpad"},
    {"input/trackpad/x", kVectorX, kBoth, "Trackpad"},
    {"input/trackpad/y", kVectorY, kBoth, "Trackpad"},
    {"input/trackpad/force", kFloat, kBoth, "Trackpad"},
    {"input/trackpad/touch", kBool, kBoth, "Trackpad"},
    {"input/grip/pose", kPose, kBoth, "Grip"},
    {"input/grip_surface/pose", kPose, kBoth, "Grip surface"},
    {"input/aim/pose", kPose, kBoth, "Aim"},
    {"output/haptic", kHaptic, kBoth, "Haptics"},
};

constexpr Component kVive[] = {
    {"input/system/click", kBool, kBoth, "System"},
    {"input/menu/click", kBool, kBoth, "Menu"},
    {"input/squeeze/click", kBool, kBoth, "Squeeze"},
    {"input/trigger/click", kBool, kBoth, "Trigger"},
    {"input/trigger/value", kFloat, kBoth, "Trigger"},
    {"input/trackpad", kVector2, kBoth, "Trackpad"},
    {"input/trackpad/x", kVectorX, kBoth, "Trackpad"},
    {"input/trackpad/y", kVectorY, kBoth, "Trackpad"},
    {"input/trackpad/click", kBool, kBoth, "Trackpad"},
    {"input/trackpad/touch", kBool, kBoth, "Trackpad"},
    {"input/grip/pose", kPose, kBoth, "Grip"},
    {"input/grip_surface/pose", kPose, kBoth, "Grip surface"},
    {"input/aim/pose", kPose, kBoth, "Aim"},
    {"output/haptic", kHaptic, kBoth, "Haptics"},
};

constexpr Component kMotion[] = {
    {"input/menu/click", kBool, kBoth, "Menu"},
    {"input/squeeze/click", kBool, kBoth, "Squeeze"},
    {"input/trigger/value", kFloat, kBoth, "Trigger"},
    {"input/thumbstick", kVector2, kBoth, "Thumbstick"},
    {"input/thumbstick/x", kVectorX, kBoth, "Thumbstick"},
    {"input/thumbstick/y", kVectorY, kBoth, "Thumbstick"},
    {"input/thumbstick/click", kBool, kBoth, "Thumbstick"},
    {"input/trackpad", kVector2, kBoth, "Trackpad"},
    {"input/trackpad/x", kVectorX, kBoth, "Trackpad"},
    {"input/trackpad/y", kVectorY, kBoth, "Trackpad"},
    {"input/trackpad/click", kBool, kBoth, "Trackpad"},
    {"input/trackpad/touch", kBool, kBoth, "Trackpad"},
    {"input/grip/pose", kPose, kBoth, "Grip"},
    {"input/grip_surface/pose", kPose, kBoth, "Grip surface"},
    {"input/aim/pose", kPose, kBoth, "Aim"},
    {"output/haptic", kHaptic, kBoth, "Haptics"},
};

constexpr Profile kProfiles[] = {
    {"/interaction_profiles/khr/simple_controller", "Simple Controller", kSimple},
    {"/interaction_profiles/oculus/touch_controller", "Touch Controller", kTouch},
    {"/interaction_profiles/valve/index_controller", "Index Controller", kIndex},
    {"/interaction_profiles/htc/vive_controller", "Vive Controller", kVive},
    {"/interaction_profiles/microsoft/motion_controller", "Motion Controller", kMotion},
};

bool Converts(ComponentType from, XrActionType to) {
  switch (to) {
    case XR_ACTION_TYPE_BOOLEAN_INPUT:
    case XR_ACTION_TYPE_FLOAT_INPUT:
      return from == kBool || from == kFloat || from == kVectorX || from == kVectorY;
    case XR_ACTION_TYPE_VECTOR2F_INPUT:
      return from == kVector2;
    case XR_ACTION_TYPE_POSE_INPUT:
      return from == kPose;
    default:
      return from == kHaptic;
  }
}

// Which component a parent path stands for, in order of preference.
std::array<std::string_view, 2> ParentSuffixes(XrActionType type) {
  switch (type) {
    case XR_ACTION_TYPE_BOOLEAN_INPUT:
      return {"/click", "/value"};
    case XR_ACTION_TYPE_FLOAT_INPUT:
      return {"/value", "/click"};
    case XR_ACTION_TYPE_POSE_INPUT:
      return {"/pose", "/pose"};
    default:
      return {"/haptic", "/haptic"};
  }
}

}  // namespace

std::span<const Profile> Profiles() { return kProfiles; }

int FindProfile(std::string_view path) {
  for (int i = 0; i < static_cast<int>(std::size(kProfiles)); ++i) {
    if (kProfiles[i].path == path) return i;
  }
  return -1;
}

int FindComponent(const Profile& profile, int hand, std::string_view path) {
  for (int i = 0; i < static_cast<int>(profile.components.size()); ++i) {
    const Component& component = profile.components[i];
    if (component.path == path && (component.hands & (1U << hand)) != 0) return i;
  }
  return -1;
}

HandPath SplitHandPath(std::string_view path) {
  for (int hand = 0; hand < kHands; ++hand) {
    const std::string_view top = kHandPaths[hand];
    if (path.size() > top.size() + 1 && path.starts_with(top) && path[top.size()] == '/') {
      return {hand, path.substr(top.size() + 1)};
    }
  }
  return {};
}

bool IsSupported(const Profile& profile, int hand, std::string_view path) {
  for (const Component& component : profile.components) {
    const std::string_view known = component.path;
    const bool is_parent = known.size() > path.size() && known.starts_with(path) && known[path.size()] == '/' &&
                           path.find('/') != std::string_view::npos;
    if ((component.hands & (1U << hand)) != 0 && (known == path || is_parent)) return true;
  }
  return false;
}

int ResolveBinding(const Profile& profile, int hand, std::string_view path, XrActionType type) {
  const int exact = FindComponent(profile, hand, path);
  if (exact >= 0 && Converts(profile.components[exact].type, type)) return exact;
  for (const std::string_view suffix : ParentSuffixes(type)) {
    const int child = FindComponent(profile, hand, std::string(path) + std::string(suffix));
    if (child >= 0 && Converts(profile.components[child].type, type)) return child;
  }
  return -1;
}

std::string_view SourceIdentifier(std::string_view component_path) {
  const size_t first = component_path.find('/');
  return component_path.substr(0, component_path.find('/', first + 1));
}

}  // namespace omni::runtime
