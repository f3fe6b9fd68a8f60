// Does the OpenXR loader find the layer's manifest, and is it one that the loader does not skip?
#include <algorithm>

#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

constexpr const char* kInstall =
    "install the layer (cmake --install), or for a build tree set "
    "XR_API_LAYER_PATH=<build>/share/openxr/1/api_layers/explicit.d";

}  // namespace

Finding LookForLayer(const Surroundings& surroundings) {
  std::vector<LayerManifest> ours = FindLayerManifests(surroundings);
  ours.erase(std::remove_if(ours.begin(), ours.end(), [](const LayerManifest& m) { return !IsOurs(m); }), ours.end());
  if (ours.empty()) {
    std::string searched;
    for (const auto& folder : LayerFolders(surroundings, false)) {
      searched += (searched.empty() ? "" : ", ") + folder.string();
    }
    return {Verdict::kFail, std::string("no manifest names ") + kLayerName + " (searched " + searched + ")", kInstall};
  }
  for (const LayerManifest& manifest : ours) {
    if (manifest.problem.empty()) continue;
    return {Verdict::kFail, manifest.file.string() + " is skipped by the loader: " + manifest.problem,
            "install the layer again: its manifest is generated, not edited"};
  }
  return {Verdict::kOk, ours[0].file.string() + (ours[0].implicit ? " (implicit)" : " (explicit)"), {}};
}

}  // namespace omni::tools
