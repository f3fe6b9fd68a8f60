// What a haptic tag says: a role, and values that override those of weaker tags key by key.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "service/haptics/scene_input.h"
#include "service/scene/haptic_keys.h"
#include "service/scene/json_reading.h"

namespace omni::scene {

enum class Role { kSolid, kIgnore, kJoystick, kVehicle, kWall, kTrack, kCheckpoint };
std::string_view NameOf(Role role);

// Warnings, each "<file>: <pointer>: what".
class Warnings {
 public:
  Warnings(std::string file, std::vector<std::string>& lines) : file_(std::move(file)), lines_(lines) {}
  void Add(const std::string& pointer, const std::string& what);

  // Further ones are left out: work on their words is, too.
  bool full() const;

 private:
  std::string file_;
  std::vector<std::string>& lines_;
};

template <class T, std::size_t kCount>
struct Values {
  std::array<std::optional<double>, kCount> number{};
};

// A texture that a tag names, checked against the document; its image is read later (haptic_texture.h).
struct TextureUse {
  std::uint32_t image = 0;
  std::uint32_t uv_set = 0;
  haptics::Wrap wrap_u = haptics::Wrap::kRepeat, wrap_v = haptics::Wrap::kRepeat;
  std::array<double, 6> to_image{1, 0, 0, 0, 1, 0};
  std::string pointer;

  bool operator==(const TextureUse& other) const {  // the same to the tick
    return image == other.image && uv_set == other.uv_set && wrap_u == other.wrap_u && wrap_v == other.wrap_v &&
           to_image == other.to_image;
  }
};
enum TextureRole : std::size_t { kStiffnessTexture, kFrictionTexture, kVibrotactileTexture, kTextureRoles };

struct HapticTag {
  bool present = false;
  std::optional<Role> role;
  std::optional<bool> double_sided;
  std::optional<bool> kinematic;
  std::optional<bool> smooth;
  std::optional<bool> extrude;
  std::optional<bool> sculptable;
  std::optional<haptics::Falloff> falloff;
  std::optional<haptics::Symmetry> symmetry;
  std::optional<std::array<double, 3>> fibre_direction;  // frame of the file's node
  std::array<std::optional<TextureUse>, kTextureRoles> textures;
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

// Radius of the tip's ball in `extras` of a scene, "haptic": {"tip": {"radius": m}} or "haptic.tip.radius"; 0: a point.
double ReadTipRadius(const Json& scene, const std::string& pointer, Warnings& warnings);

// What contradicts itself is settled with a warning: dynamic friction above static is lowered; sculptable wins over
// extrude and over softness tet; kinematic wins over sculptable and extrude. Textures and the fibres' direction, which
// need the whole document, are left to the caller.
haptics::Material MaterialOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings);
bool SameMaterial(const haptics::Material& a, const haptics::Material& b);
haptics::JoystickInput JoystickOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings);
haptics::VehicleInput VehicleOf(const HapticTag& tag);
haptics::Checkpoint CheckpointOf(const HapticTag& tag);

}  // namespace omni::scene
