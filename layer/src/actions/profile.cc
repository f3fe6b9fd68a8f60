#include "layer/src/actions/profile.h"

#include <algorithm>

namespace omni::layer {
namespace {

std::string_view Parent(std::string_view path) { return path.substr(0, path.rfind('/')); }

int FindComponent(const Profile& profile, Hand hand, std::string_view path) {
  for (std::size_t i = 0; i < profile.components.size(); ++i)
    if (profile.components[i].path == path && profile.components[i].IsOnHand(hand)) return static_cast<int>(i);
  return -1;
}

int FindPose(const Profile& profile, std::string_view path) {
  for (std::size_t i = 0; i < profile.poses.size(); ++i)
    if (profile.poses[i].path == path) return static_cast<int>(i);
  return -1;
}

// The scalar component that a path means: itself, or the first of the preferred children of a parent path.
int ScalarFor(const Profile& profile, Hand hand, XrActionType type, const std::string& local) {
  const int exact = FindComponent(profile, hand, local);
  if (exact >= 0) return exact;
  static constexpr const char* kForBoolean[] = {"/click", "/value", "/force"};
  static constexpr const char* kForFloat[] = {"/value", "/force", "/click"};
  for (const char* child : type == XR_ACTION_TYPE_BOOLEAN_INPUT ? kForBoolean : kForFloat) {
    const int found = FindComponent(profile, hand, local + child);
    if (found >= 0) return found;
  }
  return -1;
}

bool Available(const std::vector<std::string>& requires_any, const std::vector<std::string>& enabled) {
  return requires_any.empty() || std::any_of(requires_any.begin(), requires_any.end(), [&](const std::string& name) {
           return std::find(enabled.begin(), enabled.end(), name) != enabled.end();
         });
}

bool IsPathOrParent(std::string_view candidate, std::string_view path) {
  return candidate == path || candidate == Parent(path);
}

// XR_EXT_dpad_binding adds these to each thumbstick and trackpad. They are accepted but inactive for the pen.
bool IsDpad(const Profile& profile, Hand hand, std::string_view path, const std::vector<std::string>& enabled) {
  if (std::find(enabled.begin(), enabled.end(), "XR_EXT_dpad_binding") == enabled.end()) return false;
  const std::string parent(Parent(path));
  const std::string_view last = path.substr(parent.size());
  const bool is_stick = parent == "/input/thumbstick";
  if ((!is_stick && parent != "/input/trackpad") || FindComponent(profile, hand, parent + "/x") < 0) return false;
  for (const char* direction : {"/dpad_up", "/dpad_down", "/dpad_left", "/dpad_right"})
    if (last == direction) return true;
  return !is_stick && last == "/dpad_center";
}

std::optional<Binding> ResolveScalar(const Profile& profile, Hand hand, XrActionType type, const std::string& local) {
  const int index = ScalarFor(profile, hand, type, local);
  if (index < 0) return std::nullopt;
  const std::string& path = profile.components[static_cast<std::size_t>(index)].path;
  const BindingKind kind = type == XR_ACTION_TYPE_BOOLEAN_INPUT ? BindingKind::kBoolean : BindingKind::kFloat;
  return Binding{kind, index, 0, path, std::string(Parent(path))};
}

}  // namespace

std::string FullProfilePath(std::string_view name) {
  return name.empty() || name.front() == '/' ? std::string(name) : "/interaction_profiles/" + std::string(name);
}

std::string_view UserPath(Hand hand) { return hand == Hand::kLeft ? "/user/hand/left" : "/user/hand/right"; }

bool HasPath(const Profile& profile, Hand hand, std::string_view local_path, const std::vector<std::string>& enabled) {
  for (const Component& c : profile.components)
    if (c.IsOnHand(hand) && Available(c.requires_any, enabled) && IsPathOrParent(local_path, c.path)) return true;
  for (const PoseComponent& pose : profile.poses)
    if (Available(pose.requires_any, enabled) && IsPathOrParent(local_path, pose.path)) return true;
  return IsDpad(profile, hand, local_path, enabled) ||
         std::find(profile.haptics.begin(), profile.haptics.end(), local_path) != profile.haptics.end();
}

std::optional<Binding> ResolveBinding(const Profile& profile, Hand hand, XrActionType type,
                                      std::string_view full_path) {
  const std::string_view user = UserPath(hand);
  if (full_path.substr(0, user.size()) != user) return std::nullopt;
  const std::string local(full_path.substr(user.size()));
  std::optional<Binding> out;
  switch (type) {
    case XR_ACTION_TYPE_BOOLEAN_INPUT:
    case XR_ACTION_TYPE_FLOAT_INPUT:
      out = ResolveScalar(profile, hand, type, local);
      break;
    case XR_ACTION_TYPE_VECTOR2F_INPUT: {
      const int x = FindComponent(profile, hand, local + "/x");
      const int y = FindComponent(profile, hand, local + "/y");
      if (x >= 0 && y >= 0) out = Binding{BindingKind::kVector2, x, y, local, local};
      break;
    }
    case XR_ACTION_TYPE_POSE_INPUT: {
      int pose = FindPose(profile, local);
      if (pose < 0) pose = FindPose(profile, local + "/pose");
      if (pose >= 0) {
        const std::string& path = profile.poses[static_cast<std::size_t>(pose)].path;
        out = Binding{BindingKind::kPose, pose, 0, path, std::string(Parent(path))};
      }
      break;
    }
    case XR_ACTION_TYPE_VIBRATION_OUTPUT:
      if (std::find(profile.haptics.begin(), profile.haptics.end(), local) != profile.haptics.end())
        out = Binding{BindingKind::kHaptic, 0, 0, local, local};
      break;
    default:
      break;
  }
  if (out) {
    out->path.insert(0, user);
    out->identifier.insert(0, user);
  }
  return out;
}

}  // namespace omni::layer
