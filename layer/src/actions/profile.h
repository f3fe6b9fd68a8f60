// Interaction profiles as data: layer/profiles/*.json, embedded at build. A new profile is one JSON file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/spaces/pose_math.h"
#include "service/protocol/state_memory.h"

namespace omni::layer {

enum class Hand { kLeft, kRight };
std::string_view UserPath(Hand hand);

enum class ComponentType { kBoolean, kFloat };

// What the pen feeds into a component. kNone: connected, always at rest.
inline constexpr int kNoSource = -1;

struct Component {
  std::string path;  // "/input/trigger/value"
  std::string name;  // for people: "Tip force"
  ComponentType type = ComponentType::kBoolean;
  int source = kNoSource;        // protocol::InputIndex
  int click_source = kNoSource;  // the service's click, which booleans read instead of this analog component
  bool left = true;              // which hands have it
  bool right = true;
  std::vector<std::string> requires_any;  // extensions or "1.1"; empty: always there
  bool IsOnHand(Hand hand) const { return hand == Hand::kLeft ? left : right; }
};

struct PoseComponent {
  std::string path;  // "/input/grip/pose"
  std::string name;
  Pose X_TP;                              // in the tool frame T
  std::vector<std::string> requires_any;  // extensions or "1.1"; empty: always there
};

struct Profile {
  std::string path;       // "/interaction_profiles/..."
  std::string title;      // for people
  std::string extension;  // instance extension that adds it; empty: core
  int priority = 0;       // the highest of those an application suggests wins
  std::vector<Component> components;
  std::vector<PoseComponent> poses;
  std::vector<std::string> haptics;  // "/output/haptic"
};

enum class BindingKind { kBoolean, kFloat, kVector2, kPose, kHaptic };

// What one suggested path means for an action of one type.
struct Binding {
  BindingKind kind = BindingKind::kBoolean;
  int first = 0;           // index into components (kVector2: x) or poses
  int second = 0;          // kVector2: index of the y component
  std::string path;        // full path of the source: "/user/hand/right/input/trigger/value"
  std::string identifier;  // without the component: what priorities collide on
};

struct EmbeddedFile {
  const char* name;
  const char* text;
};
// Made at build from layer/profiles/*.json.
const std::vector<EmbeddedFile>& EmbeddedProfiles();

// What every controller profile has besides its own: paths that an extension or OpenXR 1.1 adds to all of them.
inline constexpr const char* kEveryProfileFile = "every_profile.json";

// Throws std::runtime_error that names file, JSON pointer, value and remedy.
Profile ParseProfile(const std::string& file, const std::string& text);

// All embedded profiles, highest priority first, each with the paths of kEveryProfileFile that it does not list itself.
std::vector<Profile> LoadProfiles();

// "oculus/touch_controller" -> "/interaction_profiles/oculus/touch_controller"; a full path stays as it is.
std::string FullProfilePath(std::string_view name);

// True: the profile has this path (component or parent of one) on that hand, given what the application enabled.
bool HasPath(const Profile& profile, Hand hand, std::string_view local_path, const std::vector<std::string>& enabled);

// The source that `full_path` gives to an action of `type`: parent paths and conversions of
// [input-suggested-bindings]. Empty: another hand, or not convertible (then the binding is ignored, as the spec says).
std::optional<Binding> ResolveBinding(const Profile& profile, Hand hand, XrActionType type, std::string_view full_path);

}  // namespace omni::layer
