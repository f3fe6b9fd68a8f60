// The functions of our extensions, and of those about render models: nullptr where the extension is not enabled.
#pragma once

#include "layer/include/openxr/omni_force_feedback.h"
#include "layer/include/openxr/omni_haptic_scene.h"
#include "layer/src/entry/omni_openxr_compat.h"
#include "tests/layer/mini_loader/mini_loader.h"

namespace omni::test {

#define OMNI_FORCE_CALLS(X)           \
  X(CreateForceFeedbackOMNIX1)        \
  X(DestroyForceFeedbackOMNIX1)       \
  X(GetForceFeedbackPropertiesOMNIX1) \
  X(ApplyForceOMNIX1) X(SetForceFeedbackConstraintsOMNIX1) X(StopForceFeedbackOMNIX1) X(GetForceFeedbackStateOMNIX1)
#define OMNI_SCENE_CALLS(X)          \
  X(CreateHapticSceneOMNIX1)         \
  X(DestroyHapticSceneOMNIX1)        \
  X(GetHapticSceneStateOMNIX1)       \
  X(GetHapticSceneDiagnosticsOMNIX1) \
  X(EnumerateHapticSceneNodesOMNIX1) \
  X(SetHapticScenePlacementOMNIX1)   \
  X(SetHapticSceneEnabledOMNIX1)     \
  X(UpdateHapticNodesOMNIX1)         \
  X(GetHapticMaterialOMNIX1) X(SetHapticMaterialOMNIX1) X(EnumerateHapticContactsOMNIX1) X(GetHapticNodeMeshOMNIX1)

#define OMNI_MODEL_CALLS(X)                \
  X(EnumerateInteractionRenderModelIdsEXT) \
  X(CreateRenderModelEXT)                  \
  X(DestroyRenderModelEXT)                 \
  X(GetRenderModelPropertiesEXT)           \
  X(GetRenderModelStateEXT)                \
  X(CreateRenderModelSpaceEXT)             \
  X(EnumerateRenderModelSubactionPathsEXT) \
  X(GetRenderModelPoseTopLevelUserPathEXT) \
  X(CreateRenderModelAssetEXT)             \
  X(DestroyRenderModelAssetEXT) X(GetRenderModelAssetDataEXT) X(GetRenderModelAssetPropertiesEXT)

struct OwnCalls {
#define OMNI_POINTER(name) PFN_xr##name name = nullptr;
  OMNI_FORCE_CALLS(OMNI_POINTER)
  OMNI_SCENE_CALLS(OMNI_POINTER)
  OMNI_MODEL_CALLS(OMNI_POINTER)
  OMNI_POINTER(GetDeviceSampleRateFB)
#undef OMNI_POINTER
};

OwnCalls LoadOwn(const MiniLoader& loader, XrInstance instance);

}  // namespace omni::test
