#pragma once
// The interaction profiles that this runtime knows, as data: OpenXR 1.0, chapter "Interaction Profile Paths".

#include <openxr/openxr.h>

#include <span>
#include <string_view>

namespace omni::runtime {

enum class ComponentType { kBool, kFloat, kVector2, kVectorX, kVectorY, kPose, kHaptic };

inline constexpr int kHands = 2;
inline constexpr unsigned kLeft = 1;
inline constexpr unsigned kRight = 2;
inline constexpr unsigned kBoth = kLeft | kRight;
inline constexpr std::string_view kHandPaths[kHands] = {"/user/hand/left", "/user/hand/right"};

struct Component {
  std::string_view path;  // below the hand: "input/trigger/value"
  ComponentType type;
  unsigned hands;
  std::string_view name;  // what a user calls it
};

struct Profile {
  std::string_view path;
  std::string_view name;
  std::span<const Component> components;
};

std::span<const Profile> Profiles();

// -1 if unknown.
int FindProfile(std::string_view path);
int FindComponent(const Profile& profile, int hand, std::string_view path);

// Splits "/user/hand/left/input/x/click" into its hand and "input/x/click"; hand -1 if it is no such path.
struct HandPath {
  int hand = -1;
  std::string_view rest;
};
HandPath SplitHandPath(std::string_view path);

// `path` names a component of the profile or the parent of one.
bool IsSupported(const Profile& profile, int hand, std::string_view path);

// The component that an action of this type reads when `path` is suggested, after the specification's rules for parent
// paths and conversions (chapter "Suggested Bindings"); -1 when there is none, which the runtime ignores.
int ResolveBinding(const Profile& profile, int hand, std::string_view path, XrActionType type);

// "input/trigger" of "input/trigger/value": what makes two sources the same one for action set priorities.
std::string_view SourceIdentifier(std::string_view component_path);

}  // namespace omni::runtime
