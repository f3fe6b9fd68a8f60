// A haptic tag: a role, and values that override those of weaker tags key by key.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "service/haptics/scene/scene_input.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/tags/haptic_keys.h"

namespace omni::scene {

enum class Role { kSolid, kIgnore, kJoystick, kVehicle, kWall, kTrack, kCheckpoint };
std::string_view NameOf(Role role);

// Warnings, each "<file>: <pointer>: what".
class Warnings {
 public:
  Warnings(std::string file, std::vector<std::string>& lines) : file_(std::move(file)), lines_(lines) {}
  void Add(const std::string& pointer, const std::string& what);

  // Further ones are dropped: callers need not compose them.
  bool full() const;

 private:
  std::string file_;
  std::vector<std::string>& lines_;
};

// The numbers that a tag gives, by their places in the table of T's fields. A hundred thousand nodes may have tags,
// most of them a number or two.
template <class T>
class Values {
 public:
  std::optional<double> Get(std::size_t key) const {
    for (const auto& [place, number] : given_) {
      if (place == key) return number;
    }
    return std::nullopt;
  }
  void Set(std::size_t key, double value) {
    for (auto& [place, number] : given_) {
      if (place == key) {
        number = value;
        return;
      }
    }
    given_.emplace_back(static_cast<std::uint8_t>(key), value);
  }
  const auto& given() const { return given_; }

 private:
  std::vector<std::pair<std::uint8_t, double>> given_;
};

// A texture that a tag names, checked against the document; its image is read later (haptic_texture.h).
struct TextureUse {
  std::uint32_t image = 0;
  std::uint32_t uv_set = 0;
  haptics::Wrap wrap_u = haptics::Wrap::kRepeat, wrap_v = haptics::Wrap::kRepeat;
  std::array<double, 6> to_image{1, 0, 0, 0, 1, 0};
  bool as_relief = false;   // its image holds normals
  double relief_scale = 1;  // of their slopes
  std::string pointer;

  bool operator==(const TextureUse& other) const {  // the same to the tick
    return image == other.image && uv_set == other.uv_set && wrap_u == other.wrap_u && wrap_v == other.wrap_v &&
           to_image == other.to_image && as_relief == other.as_relief && relief_scale == other.relief_scale;
  }
};
enum TextureRole : std::size_t { kStiffnessTexture, kFrictionTexture, kVibrotactileTexture, kRelief, kTextureRoles };

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
  std::array<std::shared_ptr<const TextureUse>, kTextureRoles> textures;
  std::optional<haptics::SoftnessModel> softness;
  Values<haptics::Material> material;
  Values<haptics::JoystickInput> joystick;
  Values<haptics::VehicleInput> vehicle;
  Values<haptics::Checkpoint> checkpoint;

  // Values of `stronger` replace those of this, key by key.
  void OverrideBy(const HapticTag& stronger);
};

// `tag`: an object of keys, a role's name, text that holds such an object, or true.
// Unknown keys, wrong types and values out of range: a warning each; the value is ignored or clamped. `besides`: a key
// of the object that is not the tag's.
HapticTag ReadTag(const Json& tag, const std::string& pointer, Warnings& warnings, std::string_view besides = {});

// Only these keys of an object that is not a tag itself.
HapticTag ReadNumbers(const Json& object, std::initializer_list<const char*> keys, const std::string& pointer,
                      Warnings& warnings);

// The short form in `extras` of a node, mesh or material: "haptic", and flat keys "haptic.stiffness" (what a person can
// type into an editor that knows only flat custom properties).
HapticTag ReadExtras(const Json& owner, const std::string& pointer, Warnings& warnings);

// Tags that an application's file gives to nodes and materials by name: as if the document had them in `extras`, and
// over those that it has there.
class NamedTags {
 public:
  // `text`: JSON, {"clay": {"stiffness": 300}}; empty: none. Throws LoadError.
  NamedTags(const std::string& text, Warnings& warnings);

  // `owner`: a node or material of the document.
  void OverrideNamed(const Json& owner, HapticTag& tag) const;

  // A warning for each name that no node and no material has. Whether there was one.
  bool WarnOfUnknown(const Json& root, Warnings& warnings) const;

 private:
  std::map<std::string, HapticTag, std::less<>> tags_;
};

// What the program that wrote the document is known to do to tags and names, and what prevents it; empty: nothing is.
std::string_view TagsLostBy(const Json& root);

// Radius of the tip's ball in `extras` of a scene, "haptic": {"tip": {"radius": m}} or "haptic.tip.radius"; 0: a point.
// `usual_m`: where there is none.
double ReadTipRadius(const Json& scene, const std::string& pointer, double usual_m, Warnings& warnings);

// Contradictions are resolved with a warning: dynamic friction above static is lowered; sculptable wins over extrude
// and over softness tet; kinematic wins over sculptable and extrude. Textures and the fibres' direction, which need the
// whole document, are left to the caller.
haptics::Material MaterialOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings);
// All fields that distinguish one material from another.
std::vector<double> FieldsOf(const haptics::Material& material);
haptics::JoystickInput JoystickOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings);
haptics::VehicleInput VehicleOf(const HapticTag& tag);
haptics::Checkpoint CheckpointOf(const HapticTag& tag);

}  // namespace omni::scene
