// Rule "DisabledByEnvironment": an implicit layer can be disabled, is not disabled now, and needs no further variable.
// The loader checks whether a variable is set, not its value. [OpenXR-API-Layers-GUI, DisabledByEnvironmentLinter]
#include "service/tools/doctor/objections.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {

Finding LintDisabledByEnvironment(const Surroundings& surroundings) {
  Objections objections;
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    if (!manifest.implicit || manifest.name.empty()) continue;
    const std::string who = manifest.name + " (" + manifest.file.string() + ")";
    if (manifest.disable_environment.empty()) {
      objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                     who + " has no disable_environment: the loader skips it because it could not be disabled",
                     "install that layer again, or remove its manifest");
    } else if (surroundings.Has(manifest.disable_environment)) {
      objections.Add(Verdict::kWarn, who + " is disabled: " + manifest.disable_environment + " is set",
                     "unset " + manifest.disable_environment + " (its value does not matter)");
    } else if (!manifest.enable_environment.empty() && !surroundings.Has(manifest.enable_environment)) {
      objections.Add(Verdict::kWarn, who + " needs " + manifest.enable_environment + ", which is not set",
                     "set " + manifest.enable_environment + " where its applications start");
    }
  }
  return objections.Sum("no implicit layer is disabled");
}

}  // namespace omni::tools
