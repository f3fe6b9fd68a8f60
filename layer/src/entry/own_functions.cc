#include "layer/src/entry/own_extensions.h"

#include "layer/include/openxr/omni_force_feedback.h"
#include "layer/include/openxr/omni_haptic_scene.h"
#include "layer/src/entry/guarded.h"

namespace omni::layer {
namespace {

constexpr const char* kForce = XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME;
constexpr const char* kScene = XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME;
constexpr const char* kModel = XR_EXT_RENDER_MODEL_EXTENSION_NAME;
constexpr const char* kHeldModel = XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME;

}  // namespace

const std::vector<OwnFunction>& OwnFunctions() {
#define OMNI_FORCE(name, method) \
  { "xr" #name, kForce, Erase(&Entry<PFN_xr##name, &ForceFeedbacks::method>::Call) }
#define OMNI_SCENE(name, method) \
  { "xr" #name, kScene, Erase(&Entry<PFN_xr##name, &HapticScenes::method>::Call) }
#define OMNI_MODEL(extension, name) \
  { "xr" #name, extension, Erase(&Entry<PFN_xr##name, &RenderModels::name>::Call) }
  static const std::vector<OwnFunction> all = [] {
    std::vector<OwnFunction> functions{
        OMNI_FORCE(CreateForceFeedbackOMNIX1, Create),
        OMNI_FORCE(DestroyForceFeedbackOMNIX1, Destroy),
        OMNI_FORCE(GetForceFeedbackPropertiesOMNIX1, GetProperties),
        OMNI_FORCE(ApplyForceOMNIX1, Apply),
        OMNI_FORCE(SetForceFeedbackConstraintsOMNIX1, SetConstraints),
        OMNI_FORCE(StopForceFeedbackOMNIX1, Stop),
        OMNI_FORCE(GetForceFeedbackStateOMNIX1, GetState),
        OMNI_SCENE(CreateHapticSceneOMNIX1, Create),
        OMNI_SCENE(DestroyHapticSceneOMNIX1, Destroy),
        OMNI_SCENE(GetHapticSceneStateOMNIX1, GetState),
        OMNI_SCENE(GetHapticSceneDiagnosticsOMNIX1, GetDiagnostics),
        OMNI_SCENE(EnumerateHapticSceneNodesOMNIX1, EnumerateNodes),
        OMNI_SCENE(SetHapticScenePlacementOMNIX1, SetPlacement),
        OMNI_SCENE(SetHapticSceneEnabledOMNIX1, SetEnabled),
        OMNI_SCENE(UpdateHapticNodesOMNIX1, MoveNodes),
        OMNI_SCENE(GetHapticMaterialOMNIX1, GetMaterial),
        OMNI_SCENE(SetHapticMaterialOMNIX1, SetMaterial),
        OMNI_SCENE(EnumerateHapticContactsOMNIX1, EnumerateContacts),
        OMNI_SCENE(GetHapticNodeMeshOMNIX1, GetNodeMesh),
        // For runtimes that have no such function.
        OMNI_MODEL(kModel, CreateRenderModelEXT),
        OMNI_MODEL(kModel, DestroyRenderModelEXT),
        OMNI_MODEL(kModel, GetRenderModelPropertiesEXT),
        OMNI_MODEL(kModel, CreateRenderModelSpaceEXT),
        OMNI_MODEL(kModel, CreateRenderModelAssetEXT),
        OMNI_MODEL(kModel, DestroyRenderModelAssetEXT),
        OMNI_MODEL(kModel, GetRenderModelAssetDataEXT),
        OMNI_MODEL(kModel, GetRenderModelAssetPropertiesEXT),
        OMNI_MODEL(kModel, GetRenderModelStateEXT),
        OMNI_MODEL(kHeldModel, EnumerateInteractionRenderModelIdsEXT),
        OMNI_MODEL(kHeldModel, EnumerateRenderModelSubactionPathsEXT),
        OMNI_MODEL(kHeldModel, GetRenderModelPoseTopLevelUserPathEXT),
        {"xrGetDeviceSampleRateFB", XR_FB_HAPTIC_PCM_EXTENSION_NAME,
         Erase(&Entry<PFN_xrGetDeviceSampleRateFB, &Vibrations::GetDeviceSampleRateFB>::Call)},
    };
    functions.insert(functions.end(), AutomationFunctions().begin(), AutomationFunctions().end());
    return functions;
  }();
#undef OMNI_FORCE
#undef OMNI_SCENE
#undef OMNI_MODEL
  return all;
}

}  // namespace omni::layer
