#include "service/tools/doctor/openxr_manifests.h"

#include <algorithm>

#include "service/base/files/whole_file.h"
#include "service/tools/common/files.h"

namespace omni::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMaxManifests = 1000;

std::vector<std::string> Split(const std::string& list, char separator) {
  std::vector<std::string> parts;
  std::size_t start = 0;
  while (start <= list.size()) {
    const std::size_t end = std::min(list.find(separator, start), list.size());
    if (end > start) parts.push_back(list.substr(start, end - start));
    start = end + 1;
  }
  return parts;
}

// A variable with a list of folders, or the standard folders below the root.
void AddFolders(const Surroundings& surroundings, const char* variable, const std::vector<std::string>& standard,
                const std::string& below, std::vector<fs::path>& folders) {
  const std::string set = surroundings.EnvironmentVariable(variable);
  for (const std::string& folder : Split(set, ':')) folders.push_back(fs::path(folder) / below);
  if (!set.empty()) return;
  for (const std::string& folder : standard) folders.push_back(surroundings.SystemPath(folder) / below);
}

std::string TextOf(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

bool IsDecimal(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// The loader reads manifests with JsonCpp, which allows comments.
json ParseFile(const fs::path& file, std::string& problem) {
  constexpr bool kThrow = true;
  base::JsonLimits limits = kManifestJson;
  limits.comments = true;
  const base::Result<std::string> text = base::ReadFile(file.string(), limits.bytes);
  if (!text.ok() || text->empty()) {
    problem = "cannot be read, is empty or is larger than 1 MiB";
    return {};
  }
  if (const base::Status checked = base::CheckJson(*text, limits); !checked.ok()) {
    problem = "is not a JSON object: " + checked.error();
    return {};
  }
  json document = json::parse(*text, nullptr, kThrow, limits.comments);
  if (!document.is_object()) problem = "is not a JSON object";
  return document;
}

std::string VersionProblem(const json& layer) {
  if (TextOf(layer, "api_version").rfind("1.", 0) != 0) return "api_layer.api_version must be \"1.0\"";
  if (!IsDecimal(TextOf(layer, "implementation_version"))) {
    return "api_layer.implementation_version must be a decimal number in a string, e.g. \"1\"";
  }
  return {};
}

void ReadLayerObject(const json& layer, LayerManifest& manifest) {
  manifest.name = TextOf(layer, "name");
  manifest.disable_environment = TextOf(layer, "disable_environment");
  manifest.enable_environment = TextOf(layer, "enable_environment");
  manifest.version = TextOf(layer, "implementation_version");
  if (const auto all = layer.find("instance_extensions"); all != layer.end() && all->is_array()) {
    for (const json& extension : *all)
      if (extension.is_object()) manifest.extensions.push_back(TextOf(extension, "name"));
  }
  const std::string library = TextOf(layer, "library_path");
  if (!library.empty()) manifest.library = ResolveLibrary(manifest.file, library);
  if (const auto functions = layer.find("functions"); functions != layer.end() && functions->is_object()) {
    const std::string renamed = TextOf(*functions, "xrNegotiateLoaderApiLayerInterface");
    if (!renamed.empty()) manifest.negotiate = renamed;
  }
  if (manifest.name.empty()) {
    manifest.problem = "api_layer.name is missing";
  } else if (library.empty()) {
    manifest.problem = "api_layer.library_path is missing";
  } else if (manifest.implicit && manifest.disable_environment.empty()) {
    manifest.problem = "api_layer.disable_environment is missing, which implicit layers must have";
  } else {
    manifest.problem = VersionProblem(layer);
  }
}

}  // namespace

std::string ResolveLibrary(const fs::path& manifest, const std::string& library_path) {
  const fs::path path(library_path);
  if (path.is_absolute() || library_path.find('/') == std::string::npos) return library_path;
  return (manifest.parent_path() / path).lexically_normal().string();
}

std::vector<fs::path> LayerFolders(const Surroundings& surroundings, bool implicit) {
  const std::string below = std::string("openxr/1/api_layers/") + (implicit ? "implicit.d" : "explicit.d");
  std::vector<fs::path> folders;
  if (!implicit && !surroundings.EnvironmentVariable("XR_API_LAYER_PATH").empty()) {
    for (const std::string& folder : Split(surroundings.EnvironmentVariable("XR_API_LAYER_PATH"), ':'))
      folders.emplace_back(folder);
    return folders;
  }
  AddFolders(surroundings, "XDG_CONFIG_DIRS", {"/etc/xdg"}, below, folders);
  folders.push_back(surroundings.SystemPath("/etc") / below);
  AddFolders(surroundings, "XDG_DATA_DIRS", {"/usr/local/share", "/usr/share"}, below, folders);
  if (const std::string data = surroundings.EnvironmentVariable("XDG_DATA_HOME"); !data.empty()) {
    folders.push_back(fs::path(data) / below);
  } else if (const std::string home = surroundings.EnvironmentVariable("HOME"); !home.empty()) {
    folders.push_back(fs::path(home) / ".local/share" / below);
  }
  return folders;
}

LayerManifest ReadLayerManifest(const fs::path& file, bool implicit) {
  LayerManifest manifest;
  manifest.file = file;
  manifest.implicit = implicit;
  const json document = ParseFile(file, manifest.problem);
  if (!manifest.problem.empty()) return manifest;
  const auto layer = document.find("api_layer");
  if (TextOf(document, "file_format_version") != "1.0.0") {
    manifest.problem = "file_format_version must be \"1.0.0\"";
  } else if (layer == document.end() || !layer->is_object()) {
    manifest.problem = "has no object \"api_layer\"";
  } else {
    ReadLayerObject(*layer, manifest);
  }
  return manifest;
}

std::vector<LayerManifest> FindLayerManifests(const Surroundings& surroundings) {
  std::vector<LayerManifest> manifests;
  for (const bool implicit : {true, false}) {
    for (const fs::path& folder : LayerFolders(surroundings, implicit)) {
      std::error_code error;
      for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        if (at->path().extension() != ".json" || manifests.size() >= kMaxManifests) continue;
        manifests.push_back(ReadLayerManifest(at->path(), implicit));
      }
    }
  }
  return manifests;
}

std::vector<fs::path> LoadersOf32Bit(const Surroundings& surroundings) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const char* folder : {"/usr/lib/i386-linux-gnu", "/usr/lib32", "/usr/local/lib32"}) {
    const fs::path file = fs::path(surroundings.SystemPath(folder)) / "libopenxr_loader.so.1";
    if (fs::exists(file, error)) found.push_back(file);
  }
  return found;
}

bool IsOurs(const LayerManifest& manifest) {
  return manifest.name == kLayerName || manifest.file.filename().string().rfind("XrApiLayer_omni", 0) == 0;
}

std::vector<std::string> EnabledByVariable(const Surroundings& surroundings) {
  return Split(surroundings.EnvironmentVariable("XR_ENABLE_API_LAYERS"), ':');
}

bool FoundByName(const std::vector<LayerManifest>& manifests, const std::string& name,
                 const Surroundings& surroundings) {
  const bool any_explicit = std::any_of(manifests.begin(), manifests.end(),
                                        [](const LayerManifest& m) { return !m.implicit && m.problem.empty(); });
  return std::any_of(manifests.begin(), manifests.end(), [&](const LayerManifest& manifest) {
    return manifest.name == name && IsUsable(manifest, surroundings) && (!manifest.implicit || any_explicit);
  });
}

bool LibraryIsThere(const LayerManifest& manifest) {
  std::error_code error;
  return manifest.library.find('/') == std::string::npos || fs::exists(manifest.library, error);
}

bool IsUsable(const LayerManifest& manifest, const Surroundings& surroundings) {
  if (!manifest.problem.empty() || !LibraryIsThere(manifest)) return false;
  if (!manifest.implicit) return true;
  if (surroundings.HasVariable(manifest.disable_environment)) return false;  // disable wins over enable
  return manifest.enable_environment.empty() || surroundings.HasVariable(manifest.enable_environment);
}

fs::path ActiveRuntime(const Surroundings& surroundings) {
  if (const std::string chosen = surroundings.EnvironmentVariable("XR_RUNTIME_JSON"); !chosen.empty()) return chosen;
  const std::string below = "openxr/1/active_runtime.json";
  std::vector<fs::path> candidates;
  if (const std::string config = surroundings.EnvironmentVariable("XDG_CONFIG_HOME"); !config.empty()) {
    candidates.push_back(fs::path(config) / below);
  } else if (const std::string home = surroundings.EnvironmentVariable("HOME"); !home.empty()) {
    candidates.push_back(fs::path(home) / ".config" / below);
  }
  AddFolders(surroundings, "XDG_CONFIG_DIRS", {"/etc/xdg"}, below, candidates);
  candidates.push_back(surroundings.SystemPath("/etc") / below);
  std::error_code error;
  const auto found = std::find_if(candidates.begin(), candidates.end(),
                                  [&error](const fs::path& candidate) { return fs::exists(candidate, error); });
  return found == candidates.end() ? fs::path() : *found;
}

}  // namespace omni::tools
