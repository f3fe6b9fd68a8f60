#include "tests/layer/patterns/pattern.h"

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

namespace omni::test::patterns {
namespace {

using Json = nlohmann::ordered_json;

// Throws if there is another key, which nothing would read.
void CheckKeys(const Json& json, std::initializer_list<const char*> known) {
  for (const auto& [key, value] : json.items()) {
    bool found = false;
    for (const char* one : known) found = found || key == one;
    if (!found) throw std::runtime_error("unknown key \"" + key + "\"");
  }
}

template <class Value>
using Words = std::initializer_list<std::pair<const char*, Value>>;

// The value of the word at `key`; without the key the first one.
template <class Value>
Value OneOf(const Json& json, const char* key, Words<Value> words) {
  if (!json.contains(key)) return words.begin()->second;
  const std::string word = json.at(key);
  for (const auto& [known, value] : words)
    if (word == known) return value;
  throw std::runtime_error(std::string(key) + ": unknown word \"" + word + "\"");
}

XrActionType TypeOf(const Json& json, const char* key) {
  return OneOf<XrActionType>(json, key,
                             {{"boolean", XR_ACTION_TYPE_BOOLEAN_INPUT},
                              {"float", XR_ACTION_TYPE_FLOAT_INPUT},
                              {"vector2", XR_ACTION_TYPE_VECTOR2F_INPUT},
                              {"pose", XR_ACTION_TYPE_POSE_INPUT},
                              {"vibration", XR_ACTION_TYPE_VIBRATION_OUTPUT}});
}

SubactionPaths PathsOf(const Json& json, SubactionPaths otherwise) {
  return OneOf<SubactionPaths>(json, "subaction_paths",
                               {{"", otherwise},
                                {"none", SubactionPaths::kNone},
                                {"its hand", SubactionPaths::kItsHand},
                                {"both hands", SubactionPaths::kBothHands}});
}

XrSpaceLocationFlags FlagsOf(const Json& names) {
  static const std::map<std::string, XrSpaceLocationFlags> known{
      {"POSITION_VALID", XR_SPACE_LOCATION_POSITION_VALID_BIT},
      {"ORIENTATION_VALID", XR_SPACE_LOCATION_ORIENTATION_VALID_BIT},
      {"POSITION_TRACKED", XR_SPACE_LOCATION_POSITION_TRACKED_BIT},
      {"ORIENTATION_TRACKED", XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT}};
  XrSpaceLocationFlags flags = 0;
  for (const std::string name : names) flags |= known.at(name);
  return flags;
}

void ReadActions(const Json& json, Pattern& pattern) {
  const bool per_hand = json.value("actions_per_hand", false);
  const SubactionPaths paths = PathsOf(json, SubactionPaths::kBothHands);
  for (const auto& [name, what] : json.at("actions").items()) {
    const bool plain = what.is_string();
    const Json type = plain ? Json{{"type", what}} : what;
    pattern.actions.push_back({name, TypeOf(type, "type"), type.value("per_hand", per_hand), PathsOf(type, paths)});
  }
}

// A path for both hands, several of them, or {"left": ..., "right": ...}.
void AddBindings(const std::string& action, const Json& where, const std::vector<int>& hands, PatternProfile& profile) {
  if (where.is_object()) {
    for (const int hand : hands)
      if (where.contains(kSides[hand])) AddBindings(action, where.at(kSides[hand]), {hand}, profile);
  } else if (where.is_array()) {
    for (const Json& one : where) AddBindings(action, one, hands, profile);
  } else {
    for (const int hand : hands)
      profile.bindings.push_back({action, hand, "/user/hand/" + std::string(kSides[hand]) + where.get<std::string>()});
  }
}

void ReadProfiles(const Json& json, Pattern& pattern) {
  for (const Json& one : json.at("profiles")) {
    PatternProfile profile{"/interaction_profiles/" + one.at("path").get<std::string>(), one.value("needs", ""), {}};
    for (const auto& [action, where] : one.at("bindings").items()) {
      if (!pattern.Find(action)) throw std::runtime_error(profile.path + ": there is no action " + action);
      AddBindings(action, where, pattern.hands, profile);
    }
    pattern.profiles.push_back(std::move(profile));
  }
}

PatternDevice ReadDevice(const Json& json, const Pattern& pattern) {
  CheckKeys(json, {"pose", "press", "haptic", "at_null", "threshold", "press_checks_active"});
  PatternDevice device{json.at("pose"),
                       json.at("press"),
                       json.value("haptic", ""),
                       json.value("at_null", false),
                       json.value("threshold", 0.5f),
                       json.value("press_checks_active", false)};
  for (const std::string& action : {device.pose, device.press, device.haptic})
    if (!action.empty() && !pattern.Find(action)) throw std::runtime_error("there is no action " + action);
  return device;
}

void ReadOrder(const Json& json, Pattern& pattern) {
  pattern.suggests_before_session = json.value("suggests_before_session", false);
  pattern.suggests_each_alone_first = json.value("suggests_each_alone_first", false);
  pattern.asks_profile_in_first_session = json.value("asks_profile_in_first_session", false);
  pattern.rejected =
      OneOf<Rejected>(json, "rejected", {{"next profile", Rejected::kNextProfile}, {"ends", Rejected::kEnds}});
  pattern.spaces = OneOf<Spaces>(json, "spaces",
                                 {{"after attach", Spaces::kAfterAttach},
                                  {"before attach", Spaces::kBeforeAttach},
                                  {"before suggestions", Spaces::kBeforeSuggestions},
                                  {"first use", Spaces::kFirstUse}});
  pattern.space_per_profile = json.value("space_per_profile", false);
  pattern.new_session = OneOf<NewSession>(json, "new_session",
                                          {{"same actions", NewSession::kSameActions},
                                           {"new actions", NewSession::kNewActions},
                                           {"new instance", NewSession::kNewInstance}});
}

void ReadReads(const Json& json, Pattern& pattern) {
  pattern.base = OneOf<XrReferenceSpaceType>(
      json, "base", {{"LOCAL", XR_REFERENCE_SPACE_TYPE_LOCAL}, {"STAGE", XR_REFERENCE_SPACE_TYPE_STAGE}});
  pattern.new_base_at_recentre = json.value("new_base_at_recentre", false);
  pattern.profile_read = OneOf<ProfileRead>(json, "profile_read",
                                            {{"never", ProfileRead::kNever},
                                             {"at event", ProfileRead::kAtEvent},
                                             {"at sync after event", ProfileRead::kAtSyncAfterEvent},
                                             {"each frame", ProfileRead::kEachFrame}});
  const Json& there = json.at("there_when");
  CheckKeys(there, {"profile", "pose_active", "press_active", "all", "any"});
  pattern.needs_profile = there.value("profile", false);
  pattern.needs_pose_active = there.value("pose_active", false);
  pattern.needs_press_active = there.value("press_active", false);
  pattern.all_flags = FlagsOf(there.value("all", Json::array()));
  pattern.any_flag = FlagsOf(there.value("any", Json::array()));
  pattern.with_velocity = json.value("with_velocity", false);
  pattern.hand = ReadDevice(json.at("hand"), pattern);
  if (json.contains("pen")) pattern.pen.push_back(ReadDevice(json.at("pen"), pattern));
  pattern.name_by = OneOf<NameBy>(json, "name_by",
                                  {{"nothing", NameBy::kNothing},
                                   {"profile", NameBy::kProfile},
                                   {"bound sources", NameBy::kBoundSources},
                                   {"localized name", NameBy::kLocalizedName}});
  pattern.model_by = OneOf<ModelBy>(json, "model_by",
                                    {{"profile", ModelBy::kProfile},
                                     {XR_MSFT_CONTROLLER_MODEL_EXTENSION_NAME, ModelBy::kMsft},
                                     {XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME, ModelBy::kInteraction}});
}

Pattern Read(const Json& json) {
  CheckKeys(json, {"id",
                   "name",
                   "version",
                   "sources",
                   "notes",
                   "extensions",
                   "hands",
                   "sets",
                   "actions_per_hand",
                   "subaction_paths",
                   "actions",
                   "profiles",
                   "suggests_before_session",
                   "suggests_each_alone_first",
                   "asks_profile_in_first_session",
                   "rejected",
                   "spaces",
                   "space_per_profile",
                   "new_session",
                   "base",
                   "new_base_at_recentre",
                   "profile_read",
                   "there_when",
                   "with_velocity",
                   "hand",
                   "pen",
                   "name_by",
                   "model_by"});
  Pattern pattern;
  pattern.name = json.at("name");
  pattern.id = json.at("id");
  pattern.version = json.value("version", "");
  pattern.notes = json.value("notes", "");
  pattern.sources = json.value("sources", std::vector<std::string>());
  pattern.program = !pattern.sources.empty();
  pattern.extensions = json.value("extensions", std::vector<std::string>());
  pattern.hands = json.value("hands", std::vector<int>{kLeftHand, kRightHand});
  pattern.sets = OneOf<ActionSets>(
      json, "sets",
      {{"one", ActionSets::kOne}, {"per hand", ActionSets::kPerHand}, {"per profile", ActionSets::kPerProfile}});
  ReadActions(json, pattern);
  ReadProfiles(json, pattern);
  ReadOrder(json, pattern);
  ReadReads(json, pattern);
  return pattern;
}

}  // namespace

const PatternAction* Pattern::Find(const std::string& action) const {
  for (const PatternAction& one : actions)
    if (one.name == action) return &one;
  return nullptr;
}

const PatternProfile* Pattern::FindProfile(const std::string& path) const {
  for (const PatternProfile& one : profiles)
    if (one.path == path) return &one;
  return nullptr;
}

const std::vector<Pattern>& Patterns() {
  static const std::vector<Pattern> all = [] {
    std::map<std::filesystem::path, Pattern> by_file;
    for (const auto& entry : std::filesystem::directory_iterator(OMNI_SOURCE_DIR "/tests/layer/patterns/data")) {
      try {
        std::ifstream in(entry.path());
        by_file[entry.path()] = Read(Json::parse(in));
      } catch (const std::exception& error) {
        throw std::runtime_error(entry.path().string() + ": " + error.what());
      }
    }
    std::vector<Pattern> list;
    for (auto& [file, pattern] : by_file) list.push_back(std::move(pattern));
    return list;
  }();
  return all;
}

}  // namespace omni::test::patterns
