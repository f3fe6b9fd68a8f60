// Rule "ExplicitLayerArchitectures": every application requests the layers named in XR_ENABLE_API_LAYERS, so each must
// be installed for every architecture that has an OpenXR loader; otherwise applications fail to start.
// [OpenXR-API-Layers-GUI, ExplicitLayerArchitecturesLinter]
#include <map>
#include <set>

#include "service/tools/doctor/elf_file.h"
#include "service/tools/doctor/objections.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

namespace fs = std::filesystem;

// Architecture -> a loader of it.
std::map<std::string, std::string> InstalledLoaders(const Surroundings& surroundings) {
  std::vector<fs::path> folders{surroundings.System("/usr/lib"), surroundings.System("/usr/lib64"),
                                surroundings.System("/usr/lib32"), surroundings.System("/usr/local/lib")};
  std::error_code error;
  for (fs::directory_iterator at(folders.front(), error), end; !error && at != end; at.increment(error))
    if (at->path().filename().string().find("-linux-") != std::string::npos) folders.push_back(at->path());
  std::map<std::string, std::string> loaders;
  for (const fs::path& folder : folders) {
    const std::string file = (folder / "libopenxr_loader.so.1").string();
    if (const auto loader = ReadElfFile(file); loader.ok()) loaders.emplace(loader->architecture(), file);
  }
  return loaders;
}

}  // namespace

Finding LintExplicitLayerArchitectures(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  const std::map<std::string, std::string> loaders = InstalledLoaders(surroundings);
  Objections objections;
  for (const std::string& name : EnabledByVariable(surroundings)) {
    std::set<std::string> available;
    for (const LayerManifest& manifest : manifests) {
      if (manifest.name != name || !manifest.problem.empty()) continue;
      if (const auto library = ReadElfFile(manifest.library); library.ok()) available.insert(library->architecture());
    }
    if (available.empty()) continue;  // rule "BadInstallation", or a bare name that dlopen finds
    for (const auto& [architecture, loader] : loaders) {
      if (available.count(architecture) != 0) continue;
      objections.Add(Verdict::kWarn,
                     name + " is enabled for all applications but not installed for " + architecture + " (" + loader +
                         "): applications of that architecture do not start",
                     "install the layer for " + architecture +
                         " too, or enable it as an implicit layer (omni layer enable) or in the application");
    }
  }
  return objections.Sum("every layer enabled by name is installed for the architecture of every loader");
}

}  // namespace omni::tools
