// The functions of XR_OMNIX1_haptic_scene; null where the application has not enabled both extensions.
#pragma once

#include <type_traits>
#include <vector>

#include "layer/include/openxr/omni_force_feedback.h"
#include "layer/include/openxr/omni_haptic_scene.h"
#include "tests/layer/support/app.h"

namespace omni::test {

inline const std::vector<const char*> kSceneExtensions = {XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME,
                                                          XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME};

struct SceneFunctions {
  explicit SceneFunctions(XrInstance instance) {
    const auto get = [instance](const char* name, auto& function) {
      function = FunctionOf<std::remove_reference_t<decltype(function)>>(instance, name);
    };
    get("xrCreateHapticSceneOMNIX1", create);
    get("xrDestroyHapticSceneOMNIX1", destroy);
    get("xrGetHapticSceneStateOMNIX1", state);
    get("xrGetHapticSceneDiagnosticsOMNIX1", diagnostics);
    get("xrEnumerateHapticSceneNodesOMNIX1", nodes);
    get("xrSetHapticScenePlacementOMNIX1", place);
    get("xrSetHapticSceneEnabledOMNIX1", enable);
    get("xrUpdateHapticNodesOMNIX1", move);
    get("xrGetHapticMaterialOMNIX1", get_material);
    get("xrSetHapticMaterialOMNIX1", set_material);
    get("xrEnumerateHapticContactsOMNIX1", contacts);
    get("xrGetHapticNodeMeshOMNIX1", mesh);
  }
  PFN_xrCreateHapticSceneOMNIX1 create = nullptr;
  PFN_xrDestroyHapticSceneOMNIX1 destroy = nullptr;
  PFN_xrGetHapticSceneStateOMNIX1 state = nullptr;
  PFN_xrGetHapticSceneDiagnosticsOMNIX1 diagnostics = nullptr;
  PFN_xrEnumerateHapticSceneNodesOMNIX1 nodes = nullptr;
  PFN_xrSetHapticScenePlacementOMNIX1 place = nullptr;
  PFN_xrSetHapticSceneEnabledOMNIX1 enable = nullptr;
  PFN_xrUpdateHapticNodesOMNIX1 move = nullptr;
  PFN_xrGetHapticMaterialOMNIX1 get_material = nullptr;
  PFN_xrSetHapticMaterialOMNIX1 set_material = nullptr;
  PFN_xrEnumerateHapticContactsOMNIX1 contacts = nullptr;
  PFN_xrGetHapticNodeMeshOMNIX1 mesh = nullptr;
};

}  // namespace omni::test
