#include "service/config/paths.h"

#include <cstdlib>
#include <filesystem>

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

std::string UserStopFile() {
  constexpr const char* kName = "/omni/emergency_stop.toml";
  if (const std::string folder = AbsoluteVariable("XDG_STATE_HOME"); !folder.empty()) return folder + kName;
  if (const std::string home = AbsoluteVariable("HOME"); !home.empty()) return home + "/.local/state" + kName;
  return {};
}

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

}  // namespace omni::config
