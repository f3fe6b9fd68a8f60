#include "service/tools/layer/layer_store.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <nlohmann/json.hpp>

#include "service/base/files/whole_file.h"
#include "service/tools/common/files.h"
#include "service/tools/doctor/elf_file.h"

namespace omni::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExplicitBelow = "openxr/1/api_layers/explicit.d";
constexpr const char* kImplicitBelow = "openxr/1/api_layers/implicit.d";
constexpr const char* kImplicitName = "XrApiLayer_omni.json";
constexpr std::size_t kMaxNoteBytes = 4096;
constexpr mode_t kReadByAll = S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH;

const char* OptionFor(LayerScope scope) { return scope == LayerScope::kUser ? "--user" : "--system"; }

base::Error CannotWrite(const fs::path& path, LayerScope scope, int reason) {
  if (reason == ENOSPC || reason == EDQUOT) return base::Error{base::WriteProblem(path.string(), reason)};
  const std::string remedy = scope == LayerScope::kSystem
                                 ? "run it as root, or enable it for this user only: omni layer enable --user"
                                 : "make that folder your own, or set XDG_DATA_HOME to one that you can write to";
  return base::Error{path.string() + ": cannot be written (" + std::strerror(reason) + "); " + remedy};
}

std::vector<LayerManifest> ManifestsIn(const fs::path& folder, bool implicit) {
  std::vector<LayerManifest> manifests;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().extension() == ".json") manifests.push_back(ReadLayerManifest(at->path(), implicit));
  }
  std::sort(manifests.begin(), manifests.end(), [](const auto& a, const auto& b) { return a.file < b.file; });
  return manifests;
}

// Where the package looks for the manifest when it is removed: it does not know a user's XDG_DATA_HOME. Empty: the
// manifest lies where it looks first.
fs::path NoteOfPlace(const Surroundings& surroundings, LayerScope scope) {
  const fs::path data = surroundings.EnvironmentVariable("XDG_DATA_HOME"),
                 home = surroundings.EnvironmentVariable("HOME");
  const bool usual = scope == LayerScope::kSystem || !data.is_absolute() || !home.is_absolute();
  return usual || data == home / ".local/share" ? fs::path() : home / ".local/share/omni/layer_manifest";
}

bool SoundAndOurs(const LayerManifest& manifest) { return manifest.problem.empty() && manifest.name == kLayerName; }

// Of another store than `folder`: with both, the loader would take either.
const LayerManifest* EnabledElsewhere(const std::vector<LayerManifest>& manifests, const fs::path& folder) {
  const auto found = std::find_if(manifests.begin(), manifests.end(), [&](const LayerManifest& manifest) {
    std::error_code error;
    return manifest.implicit && SoundAndOurs(manifest) && !fs::equivalent(manifest.file.parent_path(), folder, error);
  });
  return found == manifests.end() ? nullptr : &*found;
}

}  // namespace

base::Result<fs::path> ImplicitFolder(const Surroundings& surroundings, LayerScope scope) {
  if (scope == LayerScope::kSystem) return surroundings.SystemPath("/etc") / kImplicitBelow;
  // The XDG rules ignore values that are not absolute.
  if (const fs::path data = surroundings.EnvironmentVariable("XDG_DATA_HOME"); data.is_absolute())
    return data / kImplicitBelow;
  const fs::path home = surroundings.EnvironmentVariable("HOME");
  if (!home.is_absolute())
    return base::Error{"HOME is not set to an absolute folder; set it, or XDG_DATA_HOME, or use --system"};
  return home / ".local/share" / kImplicitBelow;
}

base::Result<LayerManifest> FindInstalledLayer(const Surroundings& surroundings) {
  std::vector<LayerManifest> candidates;
  if (!surroundings.share.empty()) candidates = ManifestsIn(surroundings.share / kExplicitBelow, false);
  for (LayerManifest& manifest : FindLayerManifests(surroundings))
    if (!manifest.implicit) candidates.push_back(std::move(manifest));
  std::string problem = std::string("no explicit manifest names ") + kLayerName;
  for (const LayerManifest& manifest : candidates) {
    if (!SoundAndOurs(manifest)) continue;
    const std::string bad = LibraryProblem(manifest.library, manifest.negotiate);
    if (bad.empty()) return manifest;
    problem = manifest.file.string() + ": " + bad;
  }
  return base::Error{problem + "; build the layer (target XrApiLayer_omni) or install it (cmake --install)"};
}

std::string DisableVariable(const LayerManifest& manifest) {
  return "DISABLE_" + manifest.name + "_" + manifest.version;
}

base::Result<std::string> ImplicitManifestText(const LayerManifest& explicit_manifest) {
  const std::string file = explicit_manifest.file.string();
  const base::Result<std::string> text = ReadJsonFile(file, kManifestJson);
  if (!text.ok()) return base::Error{text.error() + "; install the layer again"};
  nlohmann::ordered_json document = nlohmann::ordered_json::parse(*text);
  const nlohmann::ordered_json::json_pointer at("/api_layer");
  if (!document.is_object() || !document.contains(at) || !document[at].is_object())
    return base::Error{file + ": cannot be read any more; install the layer again"};
  std::error_code error;
  const fs::path library = fs::canonical(explicit_manifest.library, error);
  if (error) return base::Error{explicit_manifest.library + ": " + error.message() + "; install the layer again"};
  document[at]["library_path"] = library.string();
  document[at]["disable_environment"] = DisableVariable(explicit_manifest);
  document[at].erase("enable_environment");
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

base::Result<EnabledLayer> EnableLayer(const Surroundings& surroundings, LayerScope scope) {
  if (const std::string user = surroundings.EnvironmentVariable("SUDO_UID");
      scope == LayerScope::kUser && !user.empty() && user != "0") {
    return base::Error{
        "--user under sudo would leave files owned by root in your home; run it without sudo, or use --system"};
  }
  const base::Result<fs::path> folder = ImplicitFolder(surroundings, scope);
  if (!folder.ok()) return base::Error{folder.error()};
  const base::Result<LayerManifest> layer = FindInstalledLayer(surroundings);
  if (!layer.ok()) return base::Error{layer.error()};
  const std::vector<LayerManifest> all = FindLayerManifests(surroundings);
  if (const LayerManifest* other = EnabledElsewhere(all, *folder)) {
    return base::Error{other->file.string() + " already enables it; remove that first (omni layer disable " +
                       OptionFor(scope == LayerScope::kUser ? LayerScope::kSystem : LayerScope::kUser) + ")"};
  }
  EnabledLayer enabled{*folder / kImplicitName, false};
  std::error_code error;
  if (fs::exists(enabled.file, error)) {
    const LayerManifest there = ReadLayerManifest(enabled.file, true);
    if (!there.name.empty() && there.name != kLayerName)
      return base::Error{enabled.file.string() + " is the manifest of " + there.name + "; move it elsewhere"};
    enabled.replaced = true;
  }
  const base::Result<std::string> text = ImplicitManifestText(*layer);
  if (!text.ok()) return base::Error{text.error()};
  fs::create_directories(*folder, error);
  if (error) return CannotWrite(*folder, scope, error.value());
  if (const int reason = base::PutWholeFile(enabled.file, {*text}, {.mode = kReadByAll}); reason != 0)
    return CannotWrite(enabled.file, scope, reason);
  if (const fs::path note = NoteOfPlace(surroundings, scope); !note.empty()) {
    const auto put = base::WriteWholeFile(note.string(), enabled.file.string() + "\n", {.make_folder = true});
    if (!put.ok()) return base::Error{put.error()};
  }
  return enabled;
}

base::Result<std::vector<fs::path>> DisableLayer(const Surroundings& surroundings, LayerScope scope) {
  const base::Result<fs::path> folder = ImplicitFolder(surroundings, scope);
  if (!folder.ok()) return base::Error{folder.error()};
  std::vector<fs::path> removed;
  for (const LayerManifest& manifest : ManifestsIn(*folder, true)) {
    if (!IsOurs(manifest) || (!manifest.name.empty() && manifest.name != kLayerName)) continue;
    std::error_code error;
    fs::remove(manifest.file, error);
    if (error) {
      return base::Error{manifest.file.string() + ": cannot be removed (" + error.message() +
                         "); remove it as its owner" + (scope == LayerScope::kSystem ? ", root" : "")};
    }
    removed.push_back(manifest.file);
  }
  if (const fs::path note = NoteOfPlace(surroundings, scope); !note.empty()) {
    const auto text = base::ReadFile(note.string(), kMaxNoteBytes);
    const bool of_removed = text.ok() && std::any_of(removed.begin(), removed.end(), [&](const fs::path& file) {
                              return *text == file.string() + "\n";
                            });
    std::error_code error;
    if (of_removed) fs::remove(note, error);
  }
  return removed;
}

}  // namespace omni::tools
