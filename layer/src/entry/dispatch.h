// One list of the functions this layer touches. To add one, add a row here and a method of that name.
#pragma once

#include "layer/src/entry/omni_openxr_compat.h"

// Functions the application reaches through us: X(class of the method, name).
#define OMNI_LAYER_INTERCEPTED(X)                \
  X(Instance, PollEvent)                         \
  X(Instance, CreateSession)                     \
  X(Instance, DestroySession)                    \
  X(Instance, BeginSession)                      \
  X(Instance, EndSession)                        \
  X(Instance, WaitFrame)                         \
  X(Input, CreateActionSet)                      \
  X(Input, DestroyActionSet)                     \
  X(Input, CreateAction)                         \
  X(Input, DestroyAction)                        \
  X(Bindings, SuggestInteractionProfileBindings) \
  X(Input, AttachSessionActionSets)              \
  X(Bindings, GetCurrentInteractionProfile)      \
  X(Instance, SyncActions)                       \
  X(Input, GetActionStateBoolean)                \
  X(Input, GetActionStateFloat)                  \
  X(Input, GetActionStateVector2f)               \
  X(Input, GetActionStatePose)                   \
  X(Input, EnumerateBoundSourcesForAction)       \
  X(Input, GetInputSourceLocalizedName)          \
  X(Locator, CreateActionSpace)                  \
  X(Locator, CreateReferenceSpace)               \
  X(Instance, DestroySpace)                      \
  X(Locator, LocateSpace)                        \
  X(Locator, LocateViews)                        \
  X(Locator, EndFrame)                           \
  X(Vibrations, ApplyHapticFeedback)             \
  X(Vibrations, StopHapticFeedback)              \
  X(Instance, GetSystemProperties)               \
  X(Instance, ResultToString)                    \
  X(Instance, StructureTypeToString)

// Functions that not every runtime has (extensions, OpenXR 1.1): intercepted only if the next layer has them; otherwise
// the application gets the next layer's answer.
#define OMNI_LAYER_OPTIONAL(X)                           \
  X(Locator, LocateSpaces)                               \
  X(Locator, LocateSpacesKHR)                            \
  X(Locator, CreateHandTrackerEXT)                       \
  X(Locator, DestroyHandTrackerEXT)                      \
  X(Locator, LocateHandJointsEXT)                        \
  X(Vibrations, GetDeviceSampleRateFB)                   \
  X(RenderModels, CreateRenderModelEXT)                  \
  X(RenderModels, DestroyRenderModelEXT)                 \
  X(RenderModels, GetRenderModelPropertiesEXT)           \
  X(RenderModels, CreateRenderModelSpaceEXT)             \
  X(RenderModels, CreateRenderModelAssetEXT)             \
  X(RenderModels, DestroyRenderModelAssetEXT)            \
  X(RenderModels, GetRenderModelAssetDataEXT)            \
  X(RenderModels, GetRenderModelAssetPropertiesEXT)      \
  X(RenderModels, GetRenderModelStateEXT)                \
  X(RenderModels, EnumerateInteractionRenderModelIdsEXT) \
  X(RenderModels, EnumerateRenderModelSubactionPathsEXT) \
  X(RenderModels, GetRenderModelPoseTopLevelUserPathEXT) \
  X(RenderModels, GetControllerModelKeyMSFT)             \
  X(RenderModels, EnumerateRenderModelPathsFB)           \
  X(RenderModels, GetRenderModelPropertiesFB)

// Functions of the next layer or runtime that we only call, or that are no method of an instance.
#define OMNI_LAYER_CALLED(X)         \
  X(Below, DestroyInstance)          \
  X(Below, StringToPath)             \
  X(Below, PathToString)             \
  X(Below, EnumerateReferenceSpaces) \
  X(Below, GetInstanceProperties)

namespace omni::layer {

struct Dispatch {
  PFN_xrGetInstanceProcAddr GetInstanceProcAddr = nullptr;
#define OMNI_LAYER_MEMBER(part, name) PFN_xr##name name = nullptr;
  OMNI_LAYER_INTERCEPTED(OMNI_LAYER_MEMBER)
  OMNI_LAYER_CALLED(OMNI_LAYER_MEMBER)
  // Absent below: nullptr.
  OMNI_LAYER_OPTIONAL(OMNI_LAYER_MEMBER)
#undef OMNI_LAYER_MEMBER
  PFN_xrConvertTimespecTimeToTimeKHR ConvertTimespecTimeToTimeKHR = nullptr;
  PFN_xrEnumerateInstanceExtensionProperties EnumerateInstanceExtensionProperties = nullptr;
};

// Fills `next`. False: a core function is missing below (`*missing` names it).
bool LoadDispatch(XrInstance instance, PFN_xrGetInstanceProcAddr next_get, Dispatch& next, const char** missing);

// Our own function of that name, or nullptr. `below` is the table of the calling instance; null: there is none yet.
PFN_xrVoidFunction FindIntercepted(const char* name, const Dispatch* below);

}  // namespace omni::layer
