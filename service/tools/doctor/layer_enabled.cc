// Does an application without any knowledge of Omni get the layer?
#include <algorithm>

#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
Finding CheckEnabledLayers(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  const std::vector<std::string> names = EnabledByVariable(surroundings);
  if (std::find(names.begin(), names.end(), kLayerName) != names.end()) {
    return {Verdict::kOk, "XR_ENABLE_API_LAYERS names it", {}};
  }
  for (const LayerManifest& manifest : manifests) {
    if (manifest.name != kLayerName || !manifest.implicit) continue;
    if (IsUsable(manifest, surroundings)) {
      const auto others = LoadersOf32Bit(surroundings);
      if (others.empty()) return {Verdict::kOk, "implicit: every application gets it", {}};
      return {Verdict::kWarn,
              "implicit: every application gets it, and 32-bit ones do not start: " + others[0].string() +
                  " cannot load a 64-bit layer",
              "start 32-bit applications with " + manifest.disable_environment +
                  "=1, or name the layer for single applications: omni layer disable"};
    }
    if (surroundings.Has(manifest.disable_environment)) {
      return {Verdict::kWarn, manifest.disable_environment + " is set: no application gets the layer",
              "unset " + manifest.disable_environment};
    }
  }
  return {Verdict::kWarn, "the layer is not enabled: only applications that ask for it by name get it",
          std::string("export XR_ENABLE_API_LAYERS=") + kLayerName + ", or for all applications: omni layer enable",
          "omni layer enable"};
}

}  // namespace omni::tools
