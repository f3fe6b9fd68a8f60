// Rule "Ordering": some layers work only above or below certain others. Implicit layers are above those that are
// enabled by name; among implicit ones the order on Linux is unspecified. [OpenXR-API-Layers-GUI, OrderingLinter
// and its rules; what concerns our layer is ours]
#include <algorithm>

#include "service/tools/doctor/objections.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

// Each is the name of a layer, or of an extension that a layer provides. Above: closer to the application.
struct OrderRule {
  const char* above;
  const char* below;
  const char* why;
};
constexpr const char* kHandClicking = "XR_APILAYER_FREDEMMOTT_HandTrackedCockpitClicking";
constexpr const char* kMotionCompensation = "XR_APILAYER_NOVENDOR_motion_compensation";
constexpr const char* kToolkit = "XR_APILAYER_MBUCCHIA_toolkit";
constexpr OrderRule kOrderRules[] = {
    {kLayerName, kMotionCompensation, "it moves the spaces in which the pen is placed"},
    {kLayerName, kHandClicking, "it does not pass suggested bindings on"},
    {kMotionCompensation, kHandClicking, "the two do not work in the other order"},
    {"XR_APILAYER_NOVENDOR_XRNeckSafer", kHandClicking, "the two do not work in the other order"},
    {"XR_APILAYER_FREDEMMOTT_OpenKneeboard", kMotionCompensation,
     "it changes the poses that the upper layer draws with"},
    {"XR_APILAYER_app_racelab_Overlay", kMotionCompensation, "it changes the poses that the upper layer draws with"},
    {kHandClicking, "XR_EXT_hand_tracking", "it needs the extension that the lower layer provides"},
    {kToolkit, "XR_EXT_hand_tracking", "it needs the extension that the lower layer provides"},
    {kToolkit, "XR_EXT_eye_gaze_interaction", "it needs the extension that the lower layer provides"},
};

struct Enabled {
  const LayerManifest* manifest;
  int place;  // 0: implicit; then the place in XR_ENABLE_API_LAYERS
};

std::vector<Enabled> EnabledLayers(const std::vector<LayerManifest>& manifests, const Surroundings& surroundings) {
  const std::vector<std::string> names = EnabledByVariable(surroundings);
  std::vector<Enabled> enabled;
  for (const LayerManifest& manifest : manifests) {
    if (!IsUsable(manifest, surroundings)) continue;
    const auto named = std::find(names.begin(), names.end(), manifest.name);
    if (manifest.implicit) {
      enabled.push_back({&manifest, 0});
    } else if (named != names.end()) {
      enabled.push_back({&manifest, 1 + static_cast<int>(named - names.begin())});
    }
  }
  return enabled;
}

bool Is(const LayerManifest& manifest, const char* what) {
  return manifest.name == what ||
         std::find(manifest.extensions.begin(), manifest.extensions.end(), what) != manifest.extensions.end();
}

}  // namespace

Finding LintOrdering(const Surroundings& surroundings) {
  const std::vector<LayerManifest> manifests = FindLayerManifests(surroundings);
  const std::vector<Enabled> enabled = EnabledLayers(manifests, surroundings);
  Objections objections;
  for (const OrderRule& rule : kOrderRules) {
    for (const Enabled& above : enabled) {
      for (const Enabled& below : enabled) {
        const std::string& upper = above.manifest->name;
        const std::string& lower = below.manifest->name;
        if (upper == lower || !Is(*above.manifest, rule.above) || !Is(*below.manifest, rule.below)) continue;
        if (above.place < below.place) continue;
        const bool by_chance = above.place == 0 && below.place == 0;
        objections.Add(Verdict::kWarn,
                       upper + (by_chance ? " is above " + lower + " only by chance: both are implicit"
                                          : " must be above " + lower + ": " + rule.why),
                       "list them in XR_ENABLE_API_LAYERS in this order: " + upper + ":" + lower +
                           (by_chance ? " (and disable the implicit manifests)" : ""));
      }
    }
  }
  return objections.Sum(std::to_string(enabled.size()) + " enabled layers are in a working order");
}

}  // namespace omni::tools
