#include "service/config/scene_name.h"

#include <filesystem>
#include <system_error>
#include <vector>

#include "service/base/files/nearest_word.h"

namespace omni::config {
namespace {

namespace fs = std::filesystem;

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
