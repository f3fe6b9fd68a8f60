// What a haptic tag says: a role, and values that override those of weaker tags key by key.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "service/haptics/scene_input.h"
#include "service/scene/haptic_keys.h"
#include "service/scene/json_reading.h"

namespace omni::scene {

enum class Role { kSolid, kIgnore, kJoystick, kVehicle, kWall, kTrack, kCheckpoint };
const char* NameOf(Role role);

// Warnings, each "<file>: <pointer>: what".
class Warnings {
 public:
  Warnings(std::string file, std::vector<std::string>& lines) : file_(std::move(file)), lines_(lines) {}
  void Add(const std::string& pointer, const std::string& what);

 private:
  std::string file_;
  std::vector<std::string>& lines_;
};

template <class T, std::size_t kCount>
struct Values {
  std::array<std::optional<double>, kCount> number{};
};

struct HapticTag {
  bool present = false;
  std::optional<Role> role;
  std::optional<bool> double_sided;
  std::optional<bool> extrude;
  std::optional<haptics::SoftnessModel> softness;
  Values<haptics::Material, kMaterialKeys.size()> material;
  Values<haptics::JoystickInput, kJoystickKeys.size()> joystick;
  Values<haptics::VehicleInput, kVehicleKeys.size()> vehicle;
  Values<haptics::Checkpoint, kCheckpointKeys.size()> checkpoint;

  // What `stronger` says replaces what this says, key by key.
  void OverrideBy(const HapticTag& stronger);
};

// `tag`: an object of keys, a role's name, text that holds such an object, or true.
// Unknown keys, wrong types and values out of range: a warning each; the value is ignored or clamped.
HapticTag ReadTag(const Json& tag, const std::string& pointer, Warnings& warnings);

// The short form in `extras` of a node, mesh or material: "haptic", and flat keys "haptic.stiffness" (what a person can
// type into an editor that knows only flat custom properties).
HapticTag ReadExtras(const Json& owner, const std::string& pointer, Warnings& warnings);

// static >= dynamic friction; a tag that says otherwise: dynamic is lowered, with a warning.
haptics::Material MaterialOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings);
bool SameMaterial(const haptics::Material& a, const haptics::Material& b);
haptics::JoystickInput JoystickOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings);
haptics::VehicleInput VehicleOf(const HapticTag& tag);
haptics::Checkpoint CheckpointOf(const HapticTag& tag);

}  // namespace omni::scene
