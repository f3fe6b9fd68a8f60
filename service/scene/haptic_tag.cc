#include "service/scene/haptic_tag.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "service/scene/load_error.h"

namespace omni::scene {
namespace {

struct RoleRow {
  const char* name;
  Role role;
};
constexpr RoleRow kRoles[] = {{"solid", Role::kSolid},     {"ignore", Role::kIgnore}, {"joystick", Role::kJoystick},
                              {"vehicle", Role::kVehicle}, {"wall", Role::kWall},     {"track", Role::kTrack}};

struct ModelRow {
  const char* name;
  haptics::SoftnessModel model;
};
constexpr ModelRow kModels[] = {{"none", haptics::SoftnessModel::kNone},
                                {"winkler", haptics::SoftnessModel::kWinkler},
                                {"tet", haptics::SoftnessModel::kTet}};

std::string Text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

template <class Row, std::size_t kCount>
const Row* RowNamed(const Row (&rows)[kCount], const Json& value) {
  if (!value.is_string()) return nullptr;
  const auto found = std::find_if(std::begin(rows), std::end(rows), [&](const Row& row) { return value == row.name; });
  return found == std::end(rows) ? nullptr : found;
}

// A tag's object, walked with dotted paths.
class TagReader {
 public:
  TagReader(HapticTag& tag, Warnings& warnings) : tag_(tag), warnings_(warnings) {}

  void ReadObject(const Json& object, const std::string& prefix, const std::string& pointer) {
    const Json* role = prefix.empty() ? Find(object, "role") : nullptr;
    if (role) ReadRole(*role, Join(pointer, "role"));
    for (const auto& [key, value] : object.items()) ReadKey(prefix + key, value, Join(pointer, key));
  }

  void ReadKey(const std::string& path, const Json& value, const std::string& pointer) {
    if (path == "name" || path == "role") return;  // the role was read first: it decides which keys there are
    if (path == "doubleSided") return ReadFlag(value, pointer, tag_.double_sided);
    if (path == "extrude" && value.is_object()) tag_.extrude = true;
    if (path == "extrude" && !value.is_object()) return ReadFlag(value, pointer, tag_.extrude);
    if (path == "softness" && value.is_object() && !tag_.softness) tag_.softness = haptics::SoftnessModel::kWinkler;
    if (path == "softness.model" || (path == "softness" && !value.is_object())) return ReadModel(value, pointer);
    if (value.is_object() && IsGroup(path)) return ReadObject(value, path + ".", pointer);
    if (path.starts_with("extrude.") && !tag_.extrude) tag_.extrude = true;
    if (path.starts_with("softness.") && !tag_.softness) tag_.softness = haptics::SoftnessModel::kWinkler;
    const bool known = ReadRoleNumber(path, value, pointer);
    if (!known) warnings_.Add(pointer, "is no key of a haptic tag and is ignored; see docs/scenes.md for the keys");
  }

  void ReadRole(const Json& value, const std::string& pointer) {
    if (const RoleRow* row = RowNamed(kRoles, value)) {
      tag_.role = row->role;
    } else {
      warnings_.Add(pointer,
                    "is " + Shown(value) + ", must be solid, ignore, joystick, vehicle, wall or track; solid is used");
    }
  }

 private:
  static bool IsGroup(const std::string& path) {
    return std::any_of(kMaterialKeys.begin(), kMaterialKeys.end(),
                       [&](const auto& row) { return row.key.starts_with(path + "."); });
  }

  void ReadModel(const Json& value, const std::string& pointer) {
    if (const ModelRow* row = RowNamed(kModels, value)) {
      tag_.softness = row->model;
    } else {
      warnings_.Add(pointer, "is " + Shown(value) + ", must be none, winkler or tet; it is ignored");
    }
  }

  // 0 and 1 count as well: some editors' custom properties know no booleans.
  void ReadFlag(const Json& value, const std::string& pointer, std::optional<bool>& flag) {
    if (value.is_boolean()) {
      flag = value.get<bool>();
    } else if (value == 0 || value == 1) {
      flag = value == 1;
    } else {
      warnings_.Add(pointer, "is " + Shown(value) + ", must be true or false; it is ignored");
    }
  }

  bool ReadRoleNumber(const std::string& path, const Json& value, const std::string& pointer) {
    const Role role = tag_.role.value_or(Role::kSolid);
    if (role == Role::kJoystick) return ReadNumber(kJoystickKeys, tag_.joystick, path, value, pointer);
    if (role == Role::kVehicle) return ReadNumber(kVehicleKeys, tag_.vehicle, path, value, pointer);
    return ReadNumber(kMaterialKeys, tag_.material, path, value, pointer);
  }

  template <class T, std::size_t kCount>
  bool ReadNumber(const std::array<NumberKey<T>, kCount>& keys, Values<T, kCount>& values, const std::string& path,
                  const Json& value, const std::string& pointer) {
    for (std::size_t i = 0; i < kCount; ++i) {
      if (keys[i].key == path) {
        values.number[i] = InRange(keys[i].minimum, keys[i].maximum, keys[i].whole != nullptr,
                                   std::string(keys[i].unit), value, pointer);
        return true;
      }
    }
    return false;
  }

  std::optional<double> InRange(double minimum, double maximum, bool whole, const std::string& unit, const Json& value,
                                const std::string& pointer) {
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (!std::isfinite(number)) {
      warnings_.Add(pointer, "is " + Shown(value) + ", must be a number; the default is used");
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
};

template <class T>
void Override(std::optional<T>& weaker, const std::optional<T>& stronger) {
  if (stronger) weaker = stronger;
}

template <class T, std::size_t kCount>
void Override(Values<T, kCount>& weaker, const Values<T, kCount>& stronger) {
  for (std::size_t i = 0; i < kCount; ++i) Override(weaker.number[i], stronger.number[i]);
}

template <class T, std::size_t kCount>
T Filled(const std::array<NumberKey<T>, kCount>& keys, const Values<T, kCount>& values) {
  T filled;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (values.number[i]) keys[i].Set(filled, *values.number[i]);
  }
  return filled;
}

}  // namespace

const char* NameOf(Role role) {
  for (const RoleRow& row : kRoles) {
    if (row.role == role) return row.name;
  }
  return "solid";
}

void Warnings::Add(const std::string& pointer, const std::string& what) {
  constexpr std::size_t kMaxLines =
      200;  // a hostile file must not fill the log; the last line says that there were more
  if (lines_.size() == kMaxLines) lines_.push_back(file_ + ": further warnings are left out");
  if (lines_.size() < kMaxLines) lines_.push_back(file_ + ": " + pointer + ": " + what);
}

void HapticTag::OverrideBy(const HapticTag& stronger) {
  present = present || stronger.present;
  Override(role, stronger.role);
  Override(double_sided, stronger.double_sided);
  Override(extrude, stronger.extrude);
  Override(softness, stronger.softness);
  Override(material, stronger.material);
  Override(joystick, stronger.joystick);
  Override(vehicle, stronger.vehicle);
}

HapticTag ReadTag(const Json& tag, const std::string& pointer, Warnings& warnings) {
  HapticTag read;
  TagReader reader(read, warnings);
  read.present = true;
  if (tag.is_object()) {
    reader.ReadObject(tag, "", pointer);
  } else if (tag.is_string() && tag.get_ref<const std::string&>().starts_with("{")) {
    try {
      reader.ReadObject(ParseJson(tag.get_ref<const std::string&>()), "", pointer);
    } catch (const LoadError& error) {
      warnings.Add(pointer, std::string("text is no JSON object (") + error.what() + "); the default material is used");
    }
  } else if (tag.is_string()) {
    reader.ReadRole(tag, pointer);
  } else if (tag.is_boolean() || tag == 0 || tag == 1) {
    read.present = tag == true || tag == 1;
  } else {
    warnings.Add(pointer, "is " + Shown(tag) + ", must be an object, a role or true; the default material is used");
  }
  return read;
}

HapticTag ReadExtras(const Json& owner, const std::string& pointer, Warnings& warnings) {
  HapticTag read;
  const Json* extras = Find(owner, "extras");
  if (!extras || !extras->is_object()) return read;
  const std::string place = Join(pointer, "extras");
  if (const Json* tag = Find(*extras, "haptic")) read = ReadTag(*tag, Join(place, "haptic"), warnings);
  TagReader reader(read, warnings);
  if (const Json* role = Find(*extras, "haptic.role")) reader.ReadRole(*role, Join(place, "haptic.role"));
  for (const auto& [key, value] : extras->items()) {
    if (!key.starts_with("haptic.")) continue;
    read.present = true;
    reader.ReadKey(key.substr(7), value, Join(place, key));
  }
  return read;
}

haptics::Material MaterialOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings) {
  haptics::Material material = Filled(kMaterialKeys, tag.material);
  material.softness.model = tag.softness.value_or(haptics::SoftnessModel::kNone);
  material.extrude.enabled = tag.extrude.value_or(false);
  if (!(material.dynamic_friction <= material.static_friction)) {
    // Field 2 is staticFriction, 3 dynamicFriction. Only what was said is complained about.
    if (tag.material.number[3]) {
      warnings.Add(pointer, "dynamicFriction " + Text(material.dynamic_friction) + " is above staticFriction " +
                                Text(material.static_friction) + "; " + Text(material.static_friction) +
                                " is used for both");
    }
    material.dynamic_friction = material.static_friction;
  }
  return material;
}

bool SameMaterial(const haptics::Material& a, const haptics::Material& b) {
  return a.softness.model == b.softness.model && a.extrude.enabled == b.extrude.enabled &&
         std::all_of(kMaterialKeys.begin(), kMaterialKeys.end(),
                     [&](const auto& row) { return row.Get(a) == row.Get(b); });
}

haptics::JoystickInput JoystickOf(const HapticTag& tag, const std::string& pointer, Warnings& warnings) {
  haptics::JoystickInput joystick = Filled(kJoystickKeys, tag.joystick);
  if (!(joystick.dead_zone_m < joystick.range_m)) {
    if (tag.joystick.number[3]) {
      warnings.Add(pointer, "deadZone " + Text(joystick.dead_zone_m) + " m must be below range " +
                                Text(joystick.range_m) + " m; a tenth of the range is used");
    }
    joystick.dead_zone_m = joystick.range_m / 10;
  }
  return joystick;
}

haptics::VehicleInput VehicleOf(const HapticTag& tag) { return Filled(kVehicleKeys, tag.vehicle); }

}  // namespace omni::scene
