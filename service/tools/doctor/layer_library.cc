// Can the layer's library be opened, and is it a layer?
#include "service/tools/doctor/library_check.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {

Finding CheckLayerLibrary(const Surroundings& surroundings) {
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    if (manifest.name != kLayerName || !manifest.problem.empty()) continue;
    if (const std::string problem = LibraryProblem(manifest.library, manifest.negotiate); !problem.empty()) {
      return {Verdict::kFail, manifest.file.string() + ": " + problem,
              "build or install the layer again (target XrApiLayer_omni)"};
    }
    return {Verdict::kOk, manifest.library + " opens and exports " + manifest.negotiate, {}};
  }
  return {Verdict::kFail, "no valid manifest names a library", "fix \"layer manifest\" first"};
}

}  // namespace omni::tools
