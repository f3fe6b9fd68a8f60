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

std::string DataFolder() {
  if (const char* value = ::secure_getenv("OMNI_DATA_DIR"); value != nullptr && value[0] != '\0') return value;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path beside = (program.parent_path().parent_path() / "share/omni").lexically_normal();
  if (!error && fs::is_directory(beside, error)) return beside.string();
  return "/usr/share/omni";
}

std::string ScenesFolder() { return DataFolder() + "/scenes"; }

std::string UserAppFolder() { return InUserFolder("apps.d"); }

std::string UserCalibrationFile() { return InUserFolder("calibration.toml"); }

std::string UserAlignmentFile() { return InUserFolder("alignments.toml"); }

std::string UserInputsFile() { return InUserFolder("inputs.toml"); }

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
