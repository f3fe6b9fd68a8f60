// Rule "BadInstallation": the loader accepts every manifest, its library exists, and XR_ENABLE_API_LAYERS names only
// installed layers. [OpenXR-API-Layers-GUI, BadInstallationLinter]
#include "service/tools/doctor/objections.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

constexpr const char* kReinstall = "install that layer again, or remove its manifest";

}  // namespace

Finding LintBadInstallation(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  Objections objections;
  for (const LayerManifest& manifest : manifests) {
    if (!manifest.problem.empty()) {
      objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                     manifest.file.string() + " is skipped by the loader: " + manifest.problem, kReinstall);
    } else if (!LibraryIsThere(manifest)) {
      objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                     manifest.file.string() + " is skipped by the loader: " + manifest.library + " does not exist",
                     kReinstall);
    }
  }
  // A name without a layer makes every xrCreateInstance fail with XR_ERROR_API_LAYER_NOT_PRESENT.
  for (const std::string& name : EnabledByVariable(surroundings)) {
    if (FoundByName(manifests, name, surroundings)) continue;
    objections.Add(
        Verdict::kFail,
        "XR_ENABLE_API_LAYERS names " + name + ", which the loader does not find: no OpenXR application starts",
        "remove the name from XR_ENABLE_API_LAYERS, or install that layer (XR_API_LAYER_PATH replaces the "
        "standard folders: list them too)");
  }
  return objections.Sum(std::to_string(manifests.size()) + " layers are installed correctly");
}

}  // namespace omni::tools
