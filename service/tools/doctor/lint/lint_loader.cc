// Rule "SkippedByLoader": the loader uses every layer that it should use by its own rules.
// [OpenXR-API-Layers-GUI, SkippedByLoaderLinter]
#include <algorithm>

#include "service/tools/doctor/objections.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {

Finding LintSkippedByLoader(const Surroundings& surroundings) {
  const LoaderAnswer& loader = surroundings.loader;
  if (!loader.asked) {
    return {Verdict::kOk, "no OpenXR loader is installed: applications bring their own", {}};
  }
  if (!loader.error.empty()) {
    return {Verdict::kFail, "the OpenXR loader cannot list the layers: " + loader.error,
            "fix the manifests above; with XR_LOADER_DEBUG=all the loader prints what it reads"};
  }
  Objections objections;
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    if (!IsUsable(manifest, surroundings)) continue;  // rules "BadInstallation" and "DisabledByEnvironment"
    if (std::find(loader.layers.begin(), loader.layers.end(), manifest.name) != loader.layers.end()) continue;
    objections.Add(IsOurs(manifest) ? Verdict::kFail : Verdict::kWarn,
                   manifest.name + " (" + manifest.file.string() + ") is skipped by the loader",
                   "start an application with XR_LOADER_DEBUG=all: the loader prints why");
  }
  return objections.Sum("the loader lists " + std::to_string(loader.layers.size()) + " layers, as expected");
}

}  // namespace omni::tools
