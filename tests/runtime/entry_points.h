#pragma once
// Every function of this runtime, once: the list makes the declarations, the dispatch table and the call counters.

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <type_traits>

#include "tests/runtime/newer_openxr.h"

// X(name)
#define OMNI_RUNTIME_FUNCTIONS(X)          \
  X(GetInstanceProcAddr)                   \
  X(EnumerateInstanceExtensionProperties)  \
  X(EnumerateApiLayerProperties)           \
  X(CreateInstance)                        \
  X(DestroyInstance)                       \
  X(GetInstanceProperties)                 \
  X(PollEvent)                             \
  X(ResultToString)                        \
  X(StructureTypeToString)                 \
  X(GetSystem)                             \
  X(GetSystemProperties)                   \
  X(EnumerateEnvironmentBlendModes)        \
  X(EnumerateViewConfigurations)           \
  X(GetViewConfigurationProperties)        \
  X(EnumerateViewConfigurationViews)       \
  X(CreateSession)                         \
  X(DestroySession)                        \
  X(BeginSession)                          \
  X(EndSession)                            \
  X(RequestExitSession)                    \
  X(WaitFrame)                             \
  X(BeginFrame)                            \
  X(EndFrame)                              \
  X(LocateViews)                           \
  X(EnumerateSwapchainFormats)             \
  X(CreateSwapchain)                       \
  X(DestroySwapchain)                      \
  X(EnumerateSwapchainImages)              \
  X(AcquireSwapchainImage)                 \
  X(WaitSwapchainImage)                    \
  X(ReleaseSwapchainImage)                 \
  X(EnumerateReferenceSpaces)              \
  X(CreateReferenceSpace)                  \
  X(GetReferenceSpaceBoundsRect)           \
  X(CreateActionSpace)                     \
  X(LocateSpace)                           \
  X(DestroySpace)                          \
  X(LocateSpaces)                          \
  X(LocateSpacesKHR)                       \
  X(CreateHandTrackerEXT)                  \
  X(DestroyHandTrackerEXT)                 \
  X(LocateHandJointsEXT)                   \
  X(StringToPath)                          \
  X(PathToString)                          \
  X(CreateActionSet)                       \
  X(DestroyActionSet)                      \
  X(CreateAction)                          \
  X(DestroyAction)                         \
  X(SuggestInteractionProfileBindings)     \
  X(AttachSessionActionSets)               \
  X(GetCurrentInteractionProfile)          \
  X(SyncActions)                           \
  X(GetActionStateBoolean)                 \
  X(GetActionStateFloat)                   \
  X(GetActionStateVector2f)                \
  X(GetActionStatePose)                    \
  X(EnumerateBoundSourcesForAction)        \
  X(GetInputSourceLocalizedName)           \
  X(ApplyHapticFeedback)                   \
  X(StopHapticFeedback)                    \
  X(GetDeviceSampleRateFB)                 \
  X(CreateRenderModelEXT)                  \
  X(DestroyRenderModelEXT)                 \
  X(CreateRenderModelSpaceEXT)             \
  X(GetRenderModelPropertiesEXT)           \
  X(GetRenderModelStateEXT)                \
  X(CreateRenderModelAssetEXT)             \
  X(DestroyRenderModelAssetEXT)            \
  X(GetRenderModelAssetDataEXT)            \
  X(GetRenderModelAssetPropertiesEXT)      \
  X(EnumerateInteractionRenderModelIdsEXT) \
  X(EnumerateRenderModelSubactionPathsEXT) \
  X(GetRenderModelPoseTopLevelUserPathEXT) \
  X(SetInputDeviceActiveEXT)               \
  X(SetInputDeviceStateBoolEXT)            \
  X(SetInputDeviceStateFloatEXT)           \
  X(SetInputDeviceStateVector2fEXT)        \
  X(SetInputDeviceLocationEXT)             \
  X(GetControllerModelKeyMSFT)             \
  X(EnumerateRenderModelPathsFB)           \
  X(GetRenderModelPropertiesFB)            \
  X(ConvertTimespecTimeToTimeKHR)          \
  X(ConvertTimeToTimespecTimeKHR)

namespace omni::runtime {

// NOLINTNEXTLINE(bugprone-macro-parentheses): a declaration
#define OMNI_DECLARE(name) std::remove_pointer_t<PFN_xr##name> name;
OMNI_RUNTIME_FUNCTIONS(OMNI_DECLARE)
#undef OMNI_DECLARE

// How often a function ("xrLocateSpace") was called since the library was loaded; -1 for a name that is not ours.
long CallCount(const char* function);

}  // namespace omni::runtime
