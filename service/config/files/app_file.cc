#include "service/config/files/app_file.h"

#include <fnmatch.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "service/base/files/nearest_word.h"
#include "service/config/inputs/input_table.h"
#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxGlobBytes = 127;  // an OpenXR application name has at most 127
constexpr std::size_t kMaxPathBytes = 1024;
constexpr Range kOffset_m{-0.2, 0.2};
constexpr Range kScale{1e-4, 1e4};
constexpr Range kForceScale{0, 1};
constexpr Range kRestAfter_s{-1, 86400};
constexpr std::size_t kMaxProfileBytes = 127;
constexpr std::size_t kMaxTags = 64, kMaxNameBytes = 127;
constexpr std::string_view kProfilePrefix = "/interaction_profiles/";
constexpr std::string_view kPlacements[] = {"as_authored", "fit"};
constexpr std::string_view kTouches[] = {"tagged", "all"};
constexpr std::string_view kUps[] = {"y", "z"};

// The *.toml files of a folder in name order; a folder that is not there has none.
std::vector<std::string> TomlFiles(const std::string& folder, std::vector<std::string>& problems) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().extension() == ".toml") files.push_back(at->path().string());
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    problems.push_back(folder + ": cannot be listed (" + error.message() + "); check its permissions");
  }
  std::sort(files.begin(), files.end());
  if (files.size() > kMaxAppFiles) {
    problems.push_back(folder + ": has " + std::to_string(files.size()) + " files, the limit is " +
                       std::to_string(kMaxAppFiles) + "; skipped from " + files[kMaxAppFiles] + " on");
    files.resize(kMaxAppFiles);
  }
  return files;
}

// "oculus/touch_controller" or the full path of it; empty if absent.
std::string ReadProfile(TableReader& reader, FileProblem& problem) {
  if (!reader.table().contains("profile")) return {};
  std::string profile = reader.Text("profile", kMaxProfileBytes);
  if (profile.rfind(kProfilePrefix, 0) != 0) profile.insert(0, kProfilePrefix);
  const std::string_view name = std::string_view(profile).substr(kProfilePrefix.size());
  constexpr std::string_view kAllowed = "abcdefghijklmnopqrstuvwxyz0123456789-_./";
  const bool is_path = !name.empty() && name.find_first_not_of(kAllowed) == name.npos &&
                       std::count(name.begin(), name.end(), '/') == 1 && name.front() != '/' && name.back() != '/' &&
                       profile.size() <= kMaxProfileBytes;
  const auto names = ProfileNames();
  if (!is_path) {
    problem.Report(reader.table().get("profile"), "profile = \"" + profile +
                                                      "\" is not an interaction profile; must be like "
                                                      "\"oculus/touch_controller\"");
  } else if (std::find(names.begin(), names.end(), name) == names.end()) {
    std::string known;
    for (const std::string_view one : names) known += (known.empty() ? "" : ", ") + std::string(one);
    problem.Report(reader.table().get("profile"), "profile = \"" + std::string(name) +
                                                      "\" is not a profile of the pen; known are " + known +
                                                      base::DidYouMean(name, names));
  }
  return profile;
}

// [[tag]]: a name and the keys of a haptic tag, which are checked where scenes are read. As JSON, by name.
std::string ReadTags(TableReader& reader, FileProblem& problem) {
  toml::table by_name;
  for (const toml::table* tag : reader.Tables("tag", 1, kMaxTags)) {
    TableReader tag_reader(problem, *tag, "tag");
    const std::string name = tag_reader.Text("name", kMaxNameBytes);
    toml::table keys = *tag;
    keys.erase("name");
    if (!by_name.insert(name, std::move(keys)).second)
      problem.Report(tag->get("name"), "tag.name = \"" + name + "\" is there twice; put all keys into one [[tag]]");
  }
  std::ostringstream text;
  text << toml::json_formatter(by_name);
  if (text.str().size() > kMaxTagBytes) {
    problem.Report(reader.table().get("tag"), "tag has " + std::to_string(text.str().size()) +
                                                  " bytes in all, the limit is " + std::to_string(kMaxTagBytes));
  }
  return text.str();
}

}  // namespace

base::Result<AppEntry> ParseAppFile(const std::string& text, const std::string& file,
                                    const std::string& scenes_folder) {
  const base::Result<toml::table> parsed = ParseToml(text, file);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(file);
  TableReader reader(problem, *parsed, "");
  AppEntry entry;
  entry.file = file;
  entry.application_glob = reader.Text("application", kMaxGlobBytes);
  // A file that gives inputs need not give a scene.
  const bool has_inputs = parsed->contains("inputs");
  if (!has_inputs || parsed->contains("scene")) {
    entry.scene = (fs::path(scenes_folder) / reader.Text("scene", kMaxPathBytes)).lexically_normal().string();
  }
  entry.placement =
      reader.Choice("placement", kPlacements, "as_authored") == "fit" ? Placement::kFit : Placement::kAsAuthored;
  // A model that is fitted into reach is meant to be touched.
  const bool fit = entry.placement == Placement::kFit;
  entry.touch = reader.Choice("touch", kTouches, fit ? "all" : "tagged") == "all" ? Touch::kAll : Touch::kTagged;
  entry.up = reader.Choice("up", kUps, "y") == "z" ? Up::kZ : Up::kY;
  entry.offset_base_m = reader.Vector("offset_base_m", kOffset_m, base::Vec3{});
  entry.scale = reader.Number("scale", kScale, 1.0);
  entry.force_scale = reader.Number("force_scale", kForceScale, 1.0);
  entry.profile = ReadProfile(reader, problem);
  entry.hand = reader.Choice("hand", kHands, "auto");
  entry.rest_after_s = reader.Number("rest_after_s", kRestAfter_s, 0.0);
  if (parsed->contains("tag")) entry.tags = ReadTags(reader, problem);
  if (const toml::table* inputs = has_inputs ? reader.Table("inputs") : nullptr) {
    TableReader input_reader(problem, *inputs, "inputs");
    entry.inputs = ReadInputs(input_reader, problem);
  }
  reader.AllowKeys({"scene", "inputs", "tag"});
  reader.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  return entry;
}

AppTable LoadAppTable(const std::vector<std::string>& folders, const std::string& scenes_folder) {
  AppTable table;
  for (const std::string& folder : folders) {
    for (const std::string& file : TomlFiles(folder, table.problems)) {
      const base::Result<std::string> text = ReadTextFile(file);
      base::Result<AppEntry> entry = text.ok() ? ParseAppFile(*text, file, scenes_folder) : base::Error{text.error()};
      if (entry.ok()) {
        table.entries.push_back(std::move(*entry));
      } else {
        table.problems.push_back(entry.error());
      }
    }
  }
  return table;
}

const AppEntry* FindApp(const AppTable& table, const std::string& application) {
  const auto found = std::find_if(table.entries.begin(), table.entries.end(), [&](const AppEntry& entry) {
    return ::fnmatch(entry.application_glob.c_str(), application.c_str(), 0) == 0;
  });
  return found == table.entries.end() ? nullptr : &*found;
}

}  // namespace omni::config
