#include "service/scene/tags/haptic_tag.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "service/base/files/nearest_word.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

// A hostile file must not fill the log; the last line says that there were more.
constexpr std::size_t kMaxLines = 200;
constexpr std::size_t kMaxNames = 1000;  // among which a nearest one is looked for

using RoleWord = TagWord<Role>;
constexpr std::array kRoles = {
    RoleWord{"solid", Role::kSolid},          RoleWord{"ignore", Role::kIgnore}, RoleWord{"joystick", Role::kJoystick},
    RoleWord{"vehicle", Role::kVehicle},      RoleWord{"wall", Role::kWall},     RoleWord{"track", Role::kTrack},
    RoleWord{"checkpoint", Role::kCheckpoint}};

std::string Text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

template <class Value, std::size_t kCount>
const Value* ValueNamed(const std::array<TagWord<Value>, kCount>& words, const Json& name) {
  if (!name.is_text()) return nullptr;
  const auto found =
      std::find_if(words.begin(), words.end(), [&](const TagWord<Value>& word) { return name.text() == word.name; });
  return found == words.end() ? nullptr : &found->value;
}

// A tag's object, walked with dotted paths.
class TagReader {
 public:
  // `besides`: a key that is not the tag's.
  TagReader(HapticTag& tag, Warnings& warnings, std::string_view besides = {})
      : tag_(tag), warnings_(warnings), besides_(besides) {}

  void ReadObject(const Json& object, const std::string& prefix, const std::string& pointer) {
    const Json* role = prefix.empty() ? FindMember(object, "role") : nullptr;
    if (role) ReadRole(*role, JoinPointer(pointer, "role"));
    for (const auto& [key, value] : object.members()) {
      const std::string path = prefix + std::string(key);
      if (path != besides_) ReadKey(path, value, JoinPointer(pointer, key));
    }
  }

  void ReadKey(const std::string& path, const Json& value, const std::string& pointer) {
    if (path == "name" || path == "role") return;  // the role was read first: it decides which keys there are
    if (path == "doubleSided") return ReadFlag(value, pointer, tag_.double_sided);
    if (path == "kinematic") return ReadFlag(value, pointer, tag_.kinematic);
    if (path == "smooth") return ReadFlag(value, pointer, tag_.smooth);
    if (path == "sculptable" && value.is_object()) tag_.sculptable = true;
    if (path == "sculptable" && !value.is_object()) return ReadFlag(value, pointer, tag_.sculptable);
    if (path == "sculptable.falloff") return ReadWord(kFalloffs, value, pointer, tag_.falloff);
    if (path == "sculptable.symmetry") return ReadWord(kSymmetries, value, pointer, tag_.symmetry);
    if (path == "softness.fibreDirection") return ReadDirection(value, pointer);
    if (path == "extrude" && value.is_object()) tag_.extrude = true;
    if (path == "extrude" && !value.is_object()) return ReadFlag(value, pointer, tag_.extrude);
    if (path == "softness" && value.is_object() && !tag_.softness) tag_.softness = haptics::SoftnessModel::kWinkler;
    if (path == "softness.model" || (path == "softness" && !value.is_object())) return ReadModel(value, pointer);
    if (value.is_object() && IsGroup(path)) return ReadObject(value, path + ".", pointer);
    if (path.starts_with("extrude.") && !tag_.extrude) tag_.extrude = true;
    if (path.starts_with("sculptable.") && !tag_.sculptable) tag_.sculptable = true;
    if (path.starts_with("softness.") && !tag_.softness) tag_.softness = haptics::SoftnessModel::kWinkler;
    const bool known = ReadRoleNumber(path, value, pointer);
    if (known) return;
    warnings_.Add(pointer, "is not a key of a haptic tag and is ignored; see docs/scenes.md for the keys" +
                               (warnings_.full() ? std::string() : base::DidYouMean(path, KeysOfRole())));
  }

  void ReadRole(const Json& value, const std::string& pointer) {
    if (const Role* role = ValueNamed(kRoles, value)) {
      tag_.role = *role;
    } else {
      warnings_.Add(pointer,
                    "is " + ValueText(value) +
                        ", must be solid, ignore, joystick, vehicle, wall, track or checkpoint; solid is used" +
                        Meant(value, kRoles));
    }
  }

  // False: `fields`, a table of base::NumberField<T>, has no such key.
  template <class Fields, class T>
  bool ReadNumber(const Fields& fields, Values<T>& values, const std::string& path, const Json& value,
                  const std::string& pointer) {
    const std::size_t i = base::IndexOfKey(fields, path);
    if (i == fields.size()) return false;
    const base::NumberField<T>& field = fields[i];
    const auto number =
        InRange(field.minimum, field.maximum, field.member.whole, std::string(field.unit), value, pointer);
    if (number) values.Set(i, *number);
    return true;
  }

 private:
  // "; did you mean 'wall'?"
  template <class Value, std::size_t kCount>
  std::string Meant(const Json& value, const std::array<TagWord<Value>, kCount>& words) const {
    if (!value.is_text() || warnings_.full()) return {};
    std::vector<std::string_view> names;
    for (const TagWord<Value>& word : words) names.push_back(word.name);
    return base::DidYouMean(value.text(), names);
  }

  // Keys allowed in a tag of this role; in groups as "softness.thickness".
  std::vector<std::string> KeysOfRole() const {
    std::vector<std::string> keys{"role", "doubleSided", "kinematic", "smooth"};
    const auto add = [&keys](const auto& table) {
      for (const auto& row : table) keys.emplace_back(row.key);
    };
    const Role role = tag_.role.value_or(Role::kSolid);
    if (role == Role::kJoystick) return add(kJoystickKeys), keys;
    if (role == Role::kVehicle) return add(kVehicleKeys), keys;
    if (role == Role::kCheckpoint) return add(kCheckpointKeys), keys;
    add(base::kMaterialFields);
    for (const char* key : {"softness", "softness.model", "softness.fibreDirection", "extrude", "sculptable",
                            "sculptable.falloff", "sculptable.symmetry", "vibrotactileTexture", "vibration", "magnet"})
      keys.emplace_back(key);
    return keys;
  }

  static bool IsGroup(const std::string& path) {
    return std::any_of(base::kMaterialFields.begin(), base::kMaterialFields.end(), [&](const auto& row) {
      return row.key.size() > path.size() && row.key[path.size()] == '.' && row.key.starts_with(path);
    });
  }

  void ReadModel(const Json& value, const std::string& pointer) {
    if (const haptics::SoftnessModel* model = ValueNamed(kSoftnessModels, value)) {
      tag_.softness = *model;
    } else {
      warnings_.Add(pointer, "is " + ValueText(value) + ", must be none, winkler or tet; it is ignored" +
                                 Meant(value, kSoftnessModels));
    }
  }

  template <class Value, std::size_t kCount>
  void ReadWord(const std::array<TagWord<Value>, kCount>& words, const Json& value, const std::string& pointer,
                std::optional<Value>& read) {
    if (!tag_.sculptable) tag_.sculptable = true;
    if (const Value* known = ValueNamed(words, value)) {
      read = *known;
      return;
    }
    std::string names;
    for (const TagWord<Value>& word : words) names += (names.empty() ? "" : ", ") + std::string(word.name);
    warnings_.Add(pointer,
                  "is " + ValueText(value) + ", must be one of " + names + "; it is ignored" + Meant(value, words));
  }

  void ReadDirection(const Json& value, const std::string& pointer) {
    if (!tag_.softness) tag_.softness = haptics::SoftnessModel::kWinkler;
    std::array<double, 3> direction{};
    const std::span<const Json> numbers = value.elements();
    bool sound = numbers.size() == 3;
    for (std::size_t k = 0; sound && k < 3; ++k) {
      direction[k] = numbers[k].number();
      sound = std::abs(direction[k]) <= 1e6;
    }
    if (sound && direction != std::array<double, 3>{}) {
      tag_.fibre_direction = direction;
    } else {
      warnings_.Add(pointer, "is " + ValueText(value) + ", must be three numbers, not all zero; it is ignored");
    }
  }

  // 0 and 1 count as well: some editors' custom properties know no booleans.
  void ReadFlag(const Json& value, const std::string& pointer, std::optional<bool>& flag) {
    if (value.is_boolean()) {
      flag = value.boolean();
    } else if (value.number() == 0 || value.number() == 1) {
      flag = value.number() == 1;
    } else {
      warnings_.Add(pointer, "is " + ValueText(value) + ", must be true or false; it is ignored");
    }
  }

  bool ReadRoleNumber(const std::string& path, const Json& value, const std::string& pointer) {
    const Role role = tag_.role.value_or(Role::kSolid);
    if (role == Role::kJoystick) return ReadNumber(kJoystickKeys, tag_.joystick, path, value, pointer);
    if (role == Role::kVehicle) return ReadNumber(kVehicleKeys, tag_.vehicle, path, value, pointer);
    if (role == Role::kCheckpoint) return ReadNumber(kCheckpointKeys, tag_.checkpoint, path, value, pointer);
    return ReadNumber(base::kMaterialFields, tag_.material, path, value, pointer);
  }

  std::optional<double> InRange(double minimum, double maximum, bool whole, const std::string& unit, const Json& value,
                                const std::string& pointer) {
    const double number = value.number();
    if (!std::isfinite(number)) {
      warnings_.Add(pointer, "is " + ValueText(value) + ", must be a number; the default is used");
      return std::nullopt;
    }
    const double clamped = std::clamp(whole ? std::round(number) : number, minimum, maximum);
    if (clamped != number) {
      warnings_.Add(pointer, "is " + Text(number) + ", must be " + (whole ? "a whole number " : "") + "from " +
                                 Text(minimum) + " to " + Text(maximum) + " " + unit + "; " + Text(clamped) +
                                 " is used");
    }
    return clamped;
  }

  HapticTag& tag_;
  Warnings& warnings_;
  const std::string_view besides_;
};

template <class T>
void Override(std::optional<T>& weaker, const std::optional<T>& stronger) {
  if (stronger) weaker = stronger;
}

template <class T>
void Override(Values<T>& weaker, const Values<T>& stronger) {
  for (const auto& [key, number] : stronger.given()) weaker.Set(key, number);
}

template <class Fields, class T>
T Filled(const Fields& fields, const Values<T>& values) {
  T filled;
  for (const auto& [place, number] : values.given()) fields[place].Set(filled, number);
  return filled;
}

}  // namespace

std::string_view NameOf(Role role) { return NameOf(kRoles, role); }

bool Warnings::full() const { return lines_.size() >= kMaxLines; }

void Warnings::Add(const std::string& pointer, const std::string& what) {
  if (lines_.size() == kMaxLines) lines_.push_back(file_ + ": further warnings are left out");
  if (lines_.size() < kMaxLines) lines_.push_back(Printable(file_ + ": " + pointer + ": " + what));
}

void HapticTag::OverrideBy(const HapticTag& stronger) {
  present = present || stronger.present;
  Override(role, stronger.role);
  Override(double_sided, stronger.double_sided);
  Override(kinematic, stronger.kinematic);
  Override(smooth, stronger.smooth);
  Override(extrude, stronger.extrude);
  Override(sculptable, stronger.sculptable);
  Override(falloff, stronger.falloff);
  Override(symmetry, stronger.symmetry);
  Override(fibre_direction, stronger.fibre_direction);
  for (std::size_t i = 0; i < kTextureRoles; ++i) {
    if (stronger.textures[i]) textures[i] = stronger.textures[i];
  }
  Override(softness, stronger.softness);
  Override(material, stronger.material);
  Override(joystick, stronger.joystick);
  Override(vehicle, stronger.vehicle);
  Override(checkpoint, stronger.checkpoint);
}

HapticTag ReadTag(const Json& tag, const std::string& pointer, Warnings& warnings, std::string_view besides) {
  HapticTag read;
  TagReader reader(read, warnings, besides);
  read.present = true;
  if (tag.is_object()) {
    reader.ReadObject(tag, "", pointer);
  } else if (tag.is_text() && tag.text().starts_with("{")) {
    const base::Result<base::JsonDocument> document = base::JsonDocument::Parse(tag.text(), kSceneJson);
    if (document.ok() && document->root().is_object()) {
      reader.ReadObject(document->root(), "", pointer);
    } else {
      const std::string why = document.ok() ? "its root is not an object" : document.error();
      warnings.Add(pointer, "text is not a JSON object (" + why + "); the default material is used");
    }
  } else if (tag.is_text()) {
    reader.ReadRole(tag, pointer);
  } else if (tag.is_boolean() || tag.number() == 0 || tag.number() == 1) {
    read.present = tag.boolean() || tag.number() == 1;
  } else {
    warnings.Add(pointer, "is " + ValueText(tag) + ", must be an object, a role or true; the default material is used");
  }
  return read;
}

HapticTag ReadNumbers(const Json& object, std::initializer_list<const char*> keys, const std::string& pointer,
                      Warnings& warnings) {
  HapticTag read;
  TagReader reader(read, warnings);
  read.present = true;
  for (const char* key : keys) {
    if (const Json* value = FindMember(object, key)) reader.ReadKey(key, *value, JoinPointer(pointer, key));
  }
  return read;
}

// "Haptic": editors complete names as they like, and the tag would be missing without a word.
static void WarnOfOtherCase(const Json& extras, const std::string& place, Warnings& warnings) {
  constexpr std::string_view kKey = "haptic";
  for (const auto& [key, value] : extras.members()) {
    std::string lower(key.substr(0, kKey.size()));
    for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    const bool whole = key.size() == kKey.size() || (key.size() > kKey.size() && key[kKey.size()] == '.');
    if (lower != kKey || !whole || key.starts_with(kKey)) continue;
    warnings.Add(JoinPointer(place, key), "is no haptic tag: the key is \"haptic\", in lower case");
  }
}

HapticTag ReadExtras(const Json& owner, const std::string& pointer, Warnings& warnings) {
  HapticTag read;
  const Json* extras = FindMember(owner, "extras");
  if (!extras || !extras->is_object()) return read;
  const std::string place = JoinPointer(pointer, "extras");
  if (const Json* tag = FindMember(*extras, "haptic")) read = ReadTag(*tag, JoinPointer(place, "haptic"), warnings);
  WarnOfOtherCase(*extras, place, warnings);
  TagReader reader(read, warnings);
  if (const Json* role = FindMember(*extras, "haptic.role")) reader.ReadRole(*role, JoinPointer(place, "haptic.role"));
  for (const auto& [key, value] : extras->members()) {
    if (!key.starts_with("haptic.")) continue;
    read.present = true;
    reader.ReadKey(std::string(key.substr(7)), value, JoinPointer(place, key));
  }
  return read;
}

NamedTags::NamedTags(const std::string& text, Warnings& warnings) {
  if (text.empty()) return;
  const base::Result<base::JsonDocument> document = base::JsonDocument::Parse(text, kSceneJson);
  if (!document.ok()) throw LoadError("LoadOptions::tags_by_name", document.error());
  for (const auto& [name, tag] : document->root().members())
    tags_[std::string(name)] = ReadTag(tag, "tag \"" + std::string(name) + "\"", warnings);
}

void NamedTags::OverrideNamed(const Json& owner, HapticTag& tag) const {
  const Json* name = tags_.empty() ? nullptr : FindMember(owner, "name");
  const auto found = name && name->is_text() ? tags_.find(name->text()) : tags_.end();
  if (found != tags_.end()) tag.OverrideBy(found->second);
}

bool NamedTags::WarnOfUnknown(const Json& root, Warnings& warnings) const {
  if (tags_.empty()) return false;
  std::vector<std::string_view> names;
  std::map<std::string, bool, std::less<>> unknown;
  for (const auto& [name, tag] : tags_) unknown[name] = true;
  for (const char* key : {"nodes", "materials"}) {
    const Json* owners = FindArray(root, "", key);
    for (const Json& owner : owners ? owners->elements() : std::span<const Json>()) {
      const Json* name = FindMember(owner, "name");
      if (!name || !name->is_text()) continue;
      if (const auto found = unknown.find(name->text()); found != unknown.end()) found->second = false;
      if (names.size() < kMaxNames) names.push_back(name->text());
    }
  }
  bool any = false;
  for (const auto& [name, is_unknown] : unknown) {
    if (!is_unknown) continue;
    any = true;
    warnings.Add("tag \"" + name + "\"",
                 "is of no node and no material of this file, and is not used" + base::DidYouMean(name, names));
  }
  return any;
}

std::string_view TagsLostBy(const Json& root) {
  constexpr std::pair<std::string_view, std::string_view> kOptimisers[] = {
      {"gltfpack",
       "is gltfpack, which drops names and extras: -kn -km -ke keep those of nodes and materials, so tag these; "
       "those of meshes, and MPEG_ and OMNI_ extensions, are dropped in any case"},
      {"glTF-Transform",
       "is glTF-Transform, which drops MPEG_ and OMNI_ extensions, so tag nodes and materials in extras.haptic; its "
       "`optimize` keeps these with --flatten false --join false --instance false --palette false --prune false"}};
  const Json* asset = FindMember(root, "asset");
  const Json* generator = asset ? FindMember(*asset, "generator") : nullptr;
  if (!generator || !generator->is_text()) return {};
  for (const auto& [name, what] : kOptimisers) {
    if (generator->text().starts_with(name)) return what;
  }
  return {};
}

double ReadTipRadius(const Json& scene, const std::string& pointer, double usual_m, Warnings& warnings) {
  struct Tip {
    double radius_m = 0;
  };
  constexpr std::array kKeys = {
      base::NumberField<Tip>{"tip.radius", "m", 0, 0.01, base::AccessMember<&Tip::radius_m>(), ""}};
  const Json* extras = FindMember(scene, "extras");
  const Json* haptic = extras ? FindMember(*extras, "haptic") : nullptr;
  const Json* tip = haptic ? FindMember(*haptic, "tip") : nullptr;
  const Json* radius = tip ? FindMember(*tip, "radius") : (extras ? FindMember(*extras, "haptic.tip.radius") : nullptr);
  if (!radius) return usual_m;
  HapticTag unused;
  Values<Tip> values;
  const std::string place = JoinPointer(pointer, "extras");
  TagReader(unused, warnings)
      .ReadNumber(kKeys, values, "tip.radius", *radius,
                  tip ? JoinPointer(JoinPointer(JoinPointer(place, "haptic"), "tip"), "radius")
                      : JoinPointer(place, "haptic.tip.radius"));
  return values.Get(0).value_or(usual_m);
}

// Resolves combinations that exclude each other.
static void Settle(const HapticTag& tag, const std::string& pointer, Warnings& warnings, haptics::Material& material) {
  if (material.sculpt.enabled && tag.kinematic.value_or(false)) {
    warnings.Add(pointer, "is both kinematic and sculptable; kinematic wins, it cannot be sculpted");
    material.sculpt.enabled = false;
  }
  if (material.extrude.enabled && tag.kinematic.value_or(false)) {
    warnings.Add(pointer, "is both kinematic and extrudable; kinematic wins, its faces stay");
    material.extrude.enabled = false;
  }
  if (material.sculpt.enabled && material.extrude.enabled) {
    warnings.Add(pointer, "is both sculptable and extrudable; sculptable wins");
    material.extrude.enabled = false;
  }
  if (material.sculpt.enabled && material.softness.model == haptics::SoftnessModel::kTet) {
    warnings.Add(pointer, "is both sculptable and softness tet; sculptable wins, softness is a winkler layer");
    material.softness.model = haptics::SoftnessModel::kWinkler;
  }
}

haptics::Material MaterialOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings) {
  haptics::Material material = Filled(base::kMaterialFields, tag.material);
  material.softness.model = tag.softness.value_or(haptics::SoftnessModel::kNone);
  material.smooth = tag.smooth.value_or(false);
  material.extrude.enabled = tag.extrude.value_or(false);
  material.sculpt.enabled = tag.sculptable.value_or(false);
  material.sculpt.falloff = tag.falloff.value_or(material.sculpt.falloff);
  material.sculpt.symmetry = tag.symmetry.value_or(material.sculpt.symmetry);
  Settle(tag, pointer, warnings, material);
  if (!(material.dynamic_friction <= material.static_friction)) {
    // Only values that were given are warned about.
    if (tag.material.Get(base::IndexOfKey(base::kMaterialFields, "dynamicFriction"))) {
      warnings.Add(pointer, "dynamicFriction " + Text(material.dynamic_friction) + " is above staticFriction " +
                                Text(material.static_friction) + "; " + Text(material.static_friction) +
                                " is used for both");
    }
    material.dynamic_friction = material.static_friction;
  }
  return material;
}

std::vector<double> FieldsOf(const haptics::Material& m) {
  const auto& [x, y, z] = m.softness.fibre_direction_base;
  std::vector<double> fields = {static_cast<double>(m.smooth),
                                static_cast<double>(m.softness.model),
                                static_cast<double>(m.extrude.enabled),
                                static_cast<double>(m.sculpt.enabled),
                                static_cast<double>(m.sculpt.falloff),
                                static_cast<double>(m.sculpt.symmetry),
                                x,
                                y,
                                z,
                                static_cast<double>(m.stiffness_texture),
                                static_cast<double>(m.friction_texture),
                                static_cast<double>(m.vibrotactile_texture),
                                static_cast<double>(m.relief)};
  fields.reserve(fields.size() + base::kMaterialFields.size());
  for (const auto& row : base::kMaterialFields) fields.push_back(row.Get(m));
  return fields;
}

haptics::JoystickInput JoystickOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings) {
  haptics::JoystickInput joystick = Filled(kJoystickKeys, tag.joystick);
  if (!(joystick.dead_zone_m < joystick.range_m)) {
    if (tag.joystick.Get(base::IndexOfKey(kJoystickKeys, "deadZone"))) {
      warnings.Add(pointer, "deadZone " + Text(joystick.dead_zone_m) + " m must be below range " +
                                Text(joystick.range_m) + " m; a tenth of the range is used");
    }
    joystick.dead_zone_m = joystick.range_m / 10;
  }
  return joystick;
}

haptics::VehicleInput VehicleOf(const HapticTag& tag) { return Filled(kVehicleKeys, tag.vehicle); }

haptics::Checkpoint CheckpointOf(const HapticTag& tag) { return Filled(kCheckpointKeys, tag.checkpoint); }

}  // namespace omni::scene
