// Entry points of XR_OMNIX1_haptic_scene.
#include "layer/src/guarded.h"
#include "layer/src/haptic_scene.h"
#include "layer/src/own_functions.h"

namespace omni::layer {
namespace {

// Calls `method` of the scenes of the instance that made `handle`.
template <class Handle, class... Parameters, class... Arguments>
XrResult OnScene(Handle handle, XrResult (HapticScenes::*method)(Parameters...), Arguments... arguments) noexcept {
  return Guarded([&] {
    const auto instance = Registry::Get().Owner(handle);
    if (!instance) return XR_ERROR_HANDLE_INVALID;
    instance->Alive();
    return (instance->haptic_scenes.*method)(handle, arguments...);
  });
}

XRAPI_ATTR XrResult XRAPI_CALL CreateHapticScene(XrSession session, const XrHapticSceneCreateInfoOMNIX1* info,
                                                 XrHapticSceneOMNIX1* scene) {
  return OnScene(session, &HapticScenes::Create, info, scene);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroyHapticScene(XrHapticSceneOMNIX1 scene) {
  return OnScene(scene, &HapticScenes::Destroy);
}

XRAPI_ATTR XrResult XRAPI_CALL GetHapticSceneState(XrHapticSceneOMNIX1 scene, XrHapticSceneStateOMNIX1* state) {
  return OnScene(scene, &HapticScenes::State, state);
}

XRAPI_ATTR XrResult XRAPI_CALL GetHapticSceneDiagnostics(XrHapticSceneOMNIX1 scene, uint32_t capacity, uint32_t* count,
                                                         char* text) {
  return OnScene(scene, &HapticScenes::Diagnostics, capacity, count, text);
}

XRAPI_ATTR XrResult XRAPI_CALL EnumerateHapticSceneNodes(XrHapticSceneOMNIX1 scene, uint32_t capacity, uint32_t* count,
                                                         XrHapticSceneNodeOMNIX1* nodes) {
  return OnScene(scene, &HapticScenes::Nodes, capacity, count, nodes);
}

XRAPI_ATTR XrResult XRAPI_CALL SetHapticScenePlacement(XrHapticSceneOMNIX1 scene,
                                                       const XrHapticScenePlacementOMNIX1* placement) {
  return OnScene(scene, &HapticScenes::Place, placement);
}

XRAPI_ATTR XrResult XRAPI_CALL SetHapticSceneEnabled(XrHapticSceneOMNIX1 scene, XrBool32 enabled) {
  return OnScene(scene, &HapticScenes::Enable, enabled);
}

XRAPI_ATTR XrResult XRAPI_CALL UpdateHapticNodes(XrHapticSceneOMNIX1 scene, const XrHapticNodesUpdateInfoOMNIX1* info) {
  return OnScene(scene, &HapticScenes::MoveNodes, info);
}

XRAPI_ATTR XrResult XRAPI_CALL GetHapticMaterial(XrHapticSceneOMNIX1 scene, uint32_t index,
                                                 XrHapticMaterialOMNIX1* material) {
  return OnScene(scene, &HapticScenes::Material, index, material);
}

XRAPI_ATTR XrResult XRAPI_CALL SetHapticMaterial(XrHapticSceneOMNIX1 scene, uint32_t index,
                                                 const XrHapticMaterialOMNIX1* material) {
  return OnScene(scene, &HapticScenes::SetMaterial, index, material);
}

XRAPI_ATTR XrResult XRAPI_CALL EnumerateHapticContacts(XrHapticSceneOMNIX1 scene,
                                                       const XrHapticContactsGetInfoOMNIX1* info, uint32_t capacity,
                                                       uint32_t* count, XrHapticContactOMNIX1* contacts) {
  return OnScene(scene, &HapticScenes::Contacts, info, capacity, count, contacts);
}

XRAPI_ATTR XrResult XRAPI_CALL GetHapticNodeMesh(XrHapticSceneOMNIX1 scene, const XrHapticNodeMeshGetInfoOMNIX1* info,
                                                 XrHapticNodeMeshOMNIX1* mesh) {
  return OnScene(scene, &HapticScenes::Mesh, info, mesh);
}

}  // namespace

const std::vector<OwnFunction>& HapticSceneFunctions() {
  constexpr const char* kName = XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME;
  constexpr const char* kForce = "XR_OMNIX1_force_feedback";
  static const std::vector<OwnFunction> functions{
      {"xrCreateHapticSceneOMNIX1", kName, Erase(&CreateHapticScene), kForce},
      {"xrDestroyHapticSceneOMNIX1", kName, Erase(&DestroyHapticScene), kForce},
      {"xrGetHapticSceneStateOMNIX1", kName, Erase(&GetHapticSceneState), kForce},
      {"xrGetHapticSceneDiagnosticsOMNIX1", kName, Erase(&GetHapticSceneDiagnostics), kForce},
      {"xrEnumerateHapticSceneNodesOMNIX1", kName, Erase(&EnumerateHapticSceneNodes), kForce},
      {"xrSetHapticScenePlacementOMNIX1", kName, Erase(&SetHapticScenePlacement), kForce},
      {"xrSetHapticSceneEnabledOMNIX1", kName, Erase(&SetHapticSceneEnabled), kForce},
      {"xrUpdateHapticNodesOMNIX1", kName, Erase(&UpdateHapticNodes), kForce},
      {"xrGetHapticMaterialOMNIX1", kName, Erase(&GetHapticMaterial), kForce},
      {"xrSetHapticMaterialOMNIX1", kName, Erase(&SetHapticMaterial), kForce},
      {"xrEnumerateHapticContactsOMNIX1", kName, Erase(&EnumerateHapticContacts), kForce},
      {"xrGetHapticNodeMeshOMNIX1", kName, Erase(&GetHapticNodeMesh), kForce},
  };
  return functions;
}

}  // namespace omni::layer
