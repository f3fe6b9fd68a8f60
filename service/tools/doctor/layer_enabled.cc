// Will an application that knows nothing of Omni get the layer, and can it start at all?
#include <algorithm>
#include <sstream>

#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

std::vector<std::string> EnabledNames(const Surroundings& surroundings) {
  std::vector<std::string> names;
  std::istringstream list(surroundings.Variable("XR_ENABLE_API_LAYERS"));
  for (std::string name; std::getline(list, name, ':');) {
    if (!name.empty()) names.push_back(name);
  }
  return names;
}

// A name without a layer makes every xrCreateInstance fail with XR_ERROR_API_LAYER_NOT_PRESENT.
Finding MissingLayer(const std::string& name) {
  return {Verdict::kFail,
          "XR_ENABLE_API_LAYERS names " + name +
              ", which the loader does not find: no OpenXR "
              "application starts",
          "remove the name from XR_ENABLE_API_LAYERS, or install that layer (XR_API_LAYER_PATH replaces the standard "
          "folders: list them too)"};
}

}  // namespace

Finding LookAtEnabledLayers(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  const std::vector<std::string> names = EnabledNames(surroundings);
  for (const std::string& name : names) {
    const bool present = std::any_of(manifests.begin(), manifests.end(), [&](const LayerManifest& manifest) {
      return manifest.name == name && IsUsable(manifest, surroundings);
    });
    if (!present) return MissingLayer(name);
  }
  if (std::find(names.begin(), names.end(), kLayerName) != names.end()) {
    return {Verdict::kOk, "XR_ENABLE_API_LAYERS names it", {}};
  }
  for (const LayerManifest& manifest : manifests) {
    if (manifest.name != kLayerName || !manifest.implicit) continue;
    if (IsUsable(manifest, surroundings)) return {Verdict::kOk, "implicit: every application gets it", {}};
    if (surroundings.Has(manifest.disable_environment)) {
      return {Verdict::kWarn, manifest.disable_environment + " is set: no application gets the layer",
              "unset " + manifest.disable_environment};
    }
  }
  return {Verdict::kWarn, "the layer is not enabled: only applications that ask for it by name get it",
          std::string("export XR_ENABLE_API_LAYERS=") + kLayerName + ", or install its implicit manifest"};
}

}  // namespace omni::tools
