#include "service/config/paths.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "service/base/files/nearest_word.h"

namespace omni::config {
namespace {

namespace fs = std::filesystem;

// The XDG rules ignore values that are not absolute.
std::string AbsoluteVariable(const char* name) {
  const char* value = ::secure_getenv(name);
  return value != nullptr && value[0] == '/' ? std::string(value) : std::string();
}

// Of our settings; empty: no home.
std::string UserFolder() {
  if (const std::string folder = AbsoluteVariable("XDG_CONFIG_HOME"); !folder.empty()) return folder + "/omni";
  if (const std::string home = AbsoluteVariable("HOME"); !home.empty()) return home + "/.config/omni";
  return {};
}

std::string InUserFolder(const std::string& name) {
  const std::string folder = UserFolder();
  return folder.empty() ? folder : folder + "/" + name;
}

// Of what programs keep themselves; empty: no home.
std::string InStateFolder(const std::string& name) {
  if (const std::string folder = AbsoluteVariable("XDG_STATE_HOME"); !folder.empty()) return folder + "/omni/" + name;
  if (const std::string home = AbsoluteVariable("HOME"); !home.empty()) return home + "/.local/state/omni/" + name;
  return {};
}

constexpr const char* kExtensions[] = {".glb", ".gltf"};

// Anything but a folder: its reader reports other files that are not regular.
bool IsThere(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_directory(status);
}

// Empty: not there.
std::string Found(const fs::path& path) {
  if (IsThere(path)) return path.string();
  for (const char* extension : kExtensions) {
    fs::path longer = path;
    longer += extension;
    if (IsThere(longer)) return longer.string();
  }
  return {};
}

// Names of the scenes in a folder, with and without extension.
std::vector<std::string> ScenesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    for (const char* extension : kExtensions) {
      if (at->path().extension() != extension) continue;
      names.push_back(at->path().stem().string());
      names.push_back(at->path().filename().string());
    }
  }
  return names;
}

}  // namespace

std::string ProgramFolder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path().string();
}

std::string ShareFolder() {
  const fs::path programs = ProgramFolder();
  return programs.empty() ? std::string() : (programs.parent_path() / "share").string();
}

std::string DataFolder() {
  if (const char* value = ::secure_getenv("OMNI_DATA_DIR"); value != nullptr && value[0] != '\0') return value;
  const std::string share = ShareFolder();
  std::error_code error;
  return !share.empty() && fs::is_directory(share + "/omni", error) ? share + "/omni" : "/usr/share/omni";
}

std::string ScenesFolder() { return DataFolder() + "/scenes"; }

std::string UserAppFolder() { return InUserFolder("apps.d"); }

std::string UserCalibrationFile() { return InUserFolder("calibration.toml"); }

std::string UserAlignmentFile() { return InUserFolder("alignments.toml"); }

std::string UserFollowFile() { return InUserFolder("follow.toml"); }

std::string UserMagnetsFile() { return InUserFolder("magnets.toml"); }

std::string UserInputsFile() { return InUserFolder("inputs.toml"); }

std::string UserStopFile() { return InStateFolder("emergency_stop.toml"); }

std::string UserSculptFolder() { return InStateFolder("sculpt"); }

std::string CacheFolder() {
  if (const std::string folder = AbsoluteVariable("XDG_CACHE_HOME"); !folder.empty()) return folder + "/omni";
  if (const std::string home = AbsoluteVariable("HOME"); !home.empty()) return home + "/.cache/omni";
  return {};
}

std::vector<std::string> AppFolders() {
  std::vector<std::string> folders;
  if (std::string user = UserAppFolder(); !user.empty()) folders.push_back(std::move(user));
  folders.push_back(DataFolder() + "/apps.d");
  return folders;
}

base::Result<std::string> FindScene(const std::string& name, const std::string& scenes_folder) {
  const fs::path path(name);
  const fs::path shipped = fs::path(scenes_folder) / path;  // `path` itself, where that is absolute
  for (const fs::path& place : {path, shipped}) {
    if (std::string found = name.empty() ? std::string() : Found(place); !found.empty()) return found;
  }
  const fs::path parent = path.parent_path();
  std::vector<std::string> known;
  for (const fs::path& folder : {parent.empty() ? fs::path(".") : parent, shipped.parent_path()}) {
    for (const std::string& scene : ScenesIn(folder)) known.push_back((parent / scene).string());
  }
  const std::string other = path.is_absolute() ? "" : " and in " + scenes_folder;
  return base::Error{"there is no scene '" + name + "', with or without .glb or .gltf appended; looked in " +
                     (parent.empty() ? "this folder" : parent.string()) + other + base::DidYouMean(name, known)};
}

}  // namespace omni::config
