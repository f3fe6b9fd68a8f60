#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "layer/src/actions/profile.h"

namespace omni::layer {
namespace {

using nlohmann::json;

struct SourceName {
  const char* name;
  int index;
};

constexpr int Index(protocol::InputIndex i) { return static_cast<int>(i); }

constexpr std::array<SourceName, 10> kSources{{{"none", kNoSource},
                                               {"tip_force", Index(protocol::InputIndex::kTipForce)},
                                               {"select", Index(protocol::InputIndex::kSelect)},
                                               {"secondary", Index(protocol::InputIndex::kSecondary)},
                                               {"menu", Index(protocol::InputIndex::kMenu)},
                                               {"squeeze", Index(protocol::InputIndex::kSqueeze)},
                                               {"thumbstick_x", Index(protocol::InputIndex::kThumbstickX)},
                                               {"thumbstick_y", Index(protocol::InputIndex::kThumbstickY)},
                                               {"thumbstick_click", Index(protocol::InputIndex::kThumbstickClick)},
                                               {"docked", Index(protocol::InputIndex::kDocked)}}};

// A location in a profile file, for messages.
struct Place {
  const std::string& file;
  std::string pointer;
  [[noreturn]] void Fail(const std::string& why) const {
    throw std::runtime_error("layer/profiles/" + file + ": " + (pointer.empty() ? "/" : pointer) + ": " + why);
  }
  Place At(const std::string& key) const { return {file, pointer + "/" + key}; }
};

std::string Text(const json& object, const char* key, const Place& place) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_string() || it->get_ref<const std::string&>().empty())
    place.At(key).Fail("must be a non-empty string");
  return it->get<std::string>();
}

std::string PathText(const json& object, const std::string& prefix, const Place& place) {
  std::string path = Text(object, "path", place);
  if (path.rfind(prefix, 0) != 0) place.At("path").Fail("\"" + path + "\" must start with " + prefix);
  return path;
}

int Source(const json& object, const char* key, const char* fallback, const Place& place) {
  const std::string name = object.contains(key) ? Text(object, key, place) : fallback;
  for (const SourceName& source : kSources)
    if (name == source.name) return source.index;
  std::string known;
  for (const SourceName& source : kSources) known += std::string(known.empty() ? "" : ", ") + source.name;
  place.At(key).Fail("\"" + name + "\" is not an input of the pen; use one of: " + known);
}

template <std::size_t N>
std::array<double, N> Numbers(const json& object, const char* key, const Place& place) {
  std::array<double, N> out{};
  const auto it = object.find(key);
  if (it == object.end() || !it->is_array() || it->size() != N)
    place.At(key).Fail("must be an array of " + std::to_string(N) + " numbers");
  for (std::size_t i = 0; i < N; ++i) {
    if (!(*it)[i].is_number()) place.At(key).Fail("must hold numbers only");
    out[i] = (*it)[i].template get<double>();
  }
  return out;
}

std::vector<std::string> RequiresAny(const json& object, const Place& place) {
  std::vector<std::string> names;
  const auto it = object.find("requires_any");
  if (it == object.end()) return names;
  if (!it->is_array()) place.At("requires_any").Fail("must be an array of extensions' names, or \"1.1\"");
  for (const json& name : *it) {
    if (!name.is_string()) place.At("requires_any").Fail("must hold strings");
    names.push_back(name.get<std::string>());
  }
  return names;
}

Component ParseComponent(const json& object, const Place& place) {
  Component c;
  c.path = PathText(object, "/input/", place);
  c.name = Text(object, "name", place);
  const std::string type = Text(object, "type", place);
  if (type != "boolean" && type != "float") place.At("type").Fail("\"" + type + "\" must be boolean or float");
  c.type = type == "boolean" ? ComponentType::kBoolean : ComponentType::kFloat;
  c.source = Source(object, "source", "none", place);
  c.click_source = Source(object, "click_source", "none", place);
  if (object.contains("hand")) {
    const std::string hand = Text(object, "hand", place);
    if (hand != "left" && hand != "right") place.At("hand").Fail("\"" + hand + "\" must be left or right");
    c.left = hand == "left";
    c.right = hand == "right";
  }
  c.requires_any = RequiresAny(object, place);
  return c;
}

PoseComponent ParsePose(const json& object, const Place& place) {
  PoseComponent pose;
  pose.path = PathText(object, "/input/", place);
  pose.name = Text(object, "name", place);
  const auto p = Numbers<3>(object, "position_tool_m", place);
  const auto q = Numbers<4>(object, "orientation_tool_wxyz", place);
  const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(norm2 > 0.98 && norm2 < 1.02)) place.At("orientation_tool_wxyz").Fail("must be a unit quaternion");
  for (const double x : p)
    if (!(x >= -0.5 && x <= 0.5)) place.At("position_tool_m").Fail("must lie within 0.5 m of the tip");
  pose.X_TP = {{p[0], p[1], p[2]}, glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]))};
  pose.requires_any = RequiresAny(object, place);
  return pose;
}

const json& Array(const json& object, const char* key, const Place& place) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_array() || it->empty()) place.At(key).Fail("must be a non-empty array");
  return *it;
}

json ParseRoot(const std::string& text, const Place& place) {
  json root = json::parse(text, nullptr, false, true);
  if (root.is_discarded() || !root.is_object()) place.Fail("is not a JSON object; check commas and braces");
  return root;
}

void ParseParts(const json& root, const Place& place, Profile& profile) {
  std::size_t i = 0;
  for (const json& object : Array(root, "components", place))
    profile.components.push_back(ParseComponent(object, place.At("components").At(std::to_string(i++))));
  i = 0;
  for (const json& object : Array(root, "poses", place))
    profile.poses.push_back(ParsePose(object, place.At("poses").At(std::to_string(i++))));
}

template <class Part>
void AddMissing(const std::vector<Part>& parts, std::vector<Part>& into) {
  for (const Part& part : parts) {
    const bool listed = std::any_of(into.begin(), into.end(), [&](const Part& own) { return own.path == part.path; });
    if (!listed) into.push_back(part);
  }
}

}  // namespace

Profile ParseProfile(const std::string& file, const std::string& text) {
  const Place place{file, ""};
  const json root = ParseRoot(text, place);
  Profile profile;
  profile.path = PathText(root, "/interaction_profiles/", place);
  profile.title = Text(root, "title", place);
  if (!root.contains("extension"))
    place.At("extension").Fail("must be an extension's name, or null for a core profile");
  if (!root["extension"].is_null()) profile.extension = Text(root, "extension", place);
  if (!root.contains("priority") || !root["priority"].is_number_integer())
    place.At("priority").Fail("must be an integer");
  profile.priority = root["priority"].get<int>();
  ParseParts(root, place, profile);
  for (const json& path : Array(root, "haptics", place)) {
    if (!path.is_string()) place.At("haptics").Fail("must hold strings");
    profile.haptics.push_back(path.get<std::string>());
  }
  return profile;
}

std::vector<Profile> LoadProfiles() {
  std::vector<Profile> profiles;
  Profile every;
  for (const EmbeddedFile& file : EmbeddedProfiles()) {
    if (std::strcmp(file.name, kEveryProfileFile) == 0) {
      const std::string name = file.name;
      const Place place{name, ""};
      ParseParts(ParseRoot(file.text, place), place, every);
    } else {
      profiles.push_back(ParseProfile(file.name, file.text));
    }
  }
  for (Profile& profile : profiles) {
    AddMissing(every.components, profile.components);
    AddMissing(every.poses, profile.poses);
  }
  std::stable_sort(profiles.begin(), profiles.end(),
                   [](const Profile& a, const Profile& b) { return a.priority > b.priority; });
  return profiles;
}

}  // namespace omni::layer
