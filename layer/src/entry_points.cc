// Every function that an application or the loader can call: finds the instance, keeps exceptions in.
// What happens is in Instance, a file per subject.
#include <cstring>

#include "layer/src/create_instance.h"
#include "layer/src/guarded.h"
#include "layer/src/haptic_functions.h"
#include "layer/src/own_functions.h"

namespace omni::layer {
namespace {

XRAPI_ATTR XrResult XRAPI_CALL DestroyInstance(XrInstance instance) {
  return Guarded([&] {
    const auto record = Registry::Get().Find(instance);
    if (!record) return XR_ERROR_HANDLE_INVALID;
    record->link.SetSession(protocol::SessionState::kNone);
    const XrResult result = record->next.DestroyInstance(instance);
    if (XR_SUCCEEDED(result)) Registry::Get().Remove(instance);
    return result;
  });
}

XRAPI_ATTR XrResult XRAPI_CALL PollEvent(XrInstance instance, XrEventDataBuffer* event) {
  return On(instance, &Instance::PollEvent, event);
}

XRAPI_ATTR XrResult XRAPI_CALL CreateSession(XrInstance instance, const XrSessionCreateInfo* info, XrSession* session) {
  return On(instance, &Instance::CreateSession, info, session);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroySession(XrSession session) {
  return On(session, &Instance::DestroySession, session);
}

XRAPI_ATTR XrResult XRAPI_CALL BeginSession(XrSession session, const XrSessionBeginInfo* info) {
  return On(session, &Instance::BeginSession, session, info);
}

XRAPI_ATTR XrResult XRAPI_CALL EndSession(XrSession session) { return On(session, &Instance::EndSession, session); }

XRAPI_ATTR XrResult XRAPI_CALL WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* state) {
  return On(session, &Instance::WaitFrame, session, info, state);
}

XRAPI_ATTR XrResult XRAPI_CALL CreateActionSet(XrInstance instance, const XrActionSetCreateInfo* info,
                                               XrActionSet* set) {
  return On(instance, &Instance::CreateActionSet, info, set);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroyActionSet(XrActionSet set) { return On(set, &Instance::DestroyActionSet, set); }

XRAPI_ATTR XrResult XRAPI_CALL CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  return On(set, &Instance::CreateAction, set, info, action);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroyAction(XrAction action) { return On(action, &Instance::DestroyAction, action); }

XRAPI_ATTR XrResult XRAPI_CALL SuggestInteractionProfileBindings(XrInstance instance,
                                                                 const XrInteractionProfileSuggestedBinding* info) {
  return On(instance, &Instance::Suggest, info);
}

XRAPI_ATTR XrResult XRAPI_CALL AttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo* info) {
  return On(session, &Instance::Attach, session, info);
}

XRAPI_ATTR XrResult XRAPI_CALL GetCurrentInteractionProfile(XrSession session, XrPath user_path,
                                                            XrInteractionProfileState* state) {
  return On(session, &Instance::CurrentProfile, session, user_path, state);
}

XRAPI_ATTR XrResult XRAPI_CALL SyncActions(XrSession session, const XrActionsSyncInfo* info) {
  return On(session, &Instance::Sync, session, info);
}

XRAPI_ATTR XrResult XRAPI_CALL GetActionStateBoolean(XrSession session, const XrActionStateGetInfo* info,
                                                     XrActionStateBoolean* state) {
  return On(session, &Instance::GetBoolean, session, info, state);
}

XRAPI_ATTR XrResult XRAPI_CALL GetActionStateFloat(XrSession session, const XrActionStateGetInfo* info,
                                                   XrActionStateFloat* state) {
  return On(session, &Instance::GetFloat, session, info, state);
}

XRAPI_ATTR XrResult XRAPI_CALL GetActionStateVector2f(XrSession session, const XrActionStateGetInfo* info,
                                                      XrActionStateVector2f* state) {
  return On(session, &Instance::GetVector2f, session, info, state);
}

XRAPI_ATTR XrResult XRAPI_CALL GetActionStatePose(XrSession session, const XrActionStateGetInfo* info,
                                                  XrActionStatePose* state) {
  return On(session, &Instance::GetPose, session, info, state);
}

XRAPI_ATTR XrResult XRAPI_CALL EnumerateBoundSourcesForAction(XrSession session,
                                                              const XrBoundSourcesForActionEnumerateInfo* info,
                                                              uint32_t capacity, uint32_t* count, XrPath* sources) {
  return On(session, &Instance::BoundSources, session, info, capacity, count, sources);
}

XRAPI_ATTR XrResult XRAPI_CALL GetInputSourceLocalizedName(XrSession session,
                                                           const XrInputSourceLocalizedNameGetInfo* info,
                                                           uint32_t capacity, uint32_t* count, char* text) {
  return On(session, &Instance::SourceName, session, info, capacity, count, text);
}

XRAPI_ATTR XrResult XRAPI_CALL CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info,
                                                 XrSpace* space) {
  return On(session, &Instance::CreateActionSpace, session, info, space);
}

XRAPI_ATTR XrResult XRAPI_CALL CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info,
                                                    XrSpace* space) {
  return On(session, &Instance::CreateReferenceSpace, session, info, space);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroySpace(XrSpace space) { return On(space, &Instance::DestroySpace, space); }

XRAPI_ATTR XrResult XRAPI_CALL LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
  return On(space, &Instance::LocateSpace, space, base, time, location);
}

XRAPI_ATTR XrResult XRAPI_CALL LocateSpaces(XrSession session, const XrSpacesLocateInfo* info,
                                            XrSpaceLocations* locations) {
  return On(session, &Instance::LocateSpaces, session, info, locations);
}

XRAPI_ATTR XrResult XRAPI_CALL LocateSpacesKHR(XrSession session, const XrSpacesLocateInfo* info,
                                               XrSpaceLocations* locations) {
  return On(session, &Instance::LocateSpacesKHR, session, info, locations);
}

XRAPI_ATTR XrResult XRAPI_CALL LocateViews(XrSession session, const XrViewLocateInfo* info, XrViewState* state,
                                           uint32_t capacity, uint32_t* count, XrView* views) {
  return On(session, &Instance::LocateViews, session, info, state, capacity, count, views);
}

XRAPI_ATTR XrResult XRAPI_CALL CreateHandTrackerEXT(XrSession session, const XrHandTrackerCreateInfoEXT* info,
                                                    XrHandTrackerEXT* tracker) {
  return On(session, &Instance::CreateHandTracker, session, info, tracker);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroyHandTrackerEXT(XrHandTrackerEXT tracker) {
  return On(tracker, &Instance::DestroyHandTracker, tracker);
}

XRAPI_ATTR XrResult XRAPI_CALL LocateHandJointsEXT(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT* info,
                                                   XrHandJointLocationsEXT* locations) {
  return On(tracker, &Instance::LocateHandJoints, tracker, info, locations);
}

XRAPI_ATTR XrResult XRAPI_CALL EndFrame(XrSession session, const XrFrameEndInfo* info) {
  return On(session, &Instance::EndFrame, session, info);
}

XRAPI_ATTR XrResult XRAPI_CALL ApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info,
                                                   const XrHapticBaseHeader* haptic) {
  return On(session, &Instance::ApplyHaptic, session, info, haptic);
}

XRAPI_ATTR XrResult XRAPI_CALL StopHapticFeedback(XrSession session, const XrHapticActionInfo* info) {
  return On(session, &Instance::StopHaptic, session, info);
}

XRAPI_ATTR XrResult XRAPI_CALL GetSystemProperties(XrInstance instance, XrSystemId system,
                                                   XrSystemProperties* properties) {
  return On(instance, &Instance::SystemProperties, system, properties);
}

XRAPI_ATTR XrResult XRAPI_CALL ResultToString(XrInstance instance, XrResult value,
                                              char buffer[XR_MAX_RESULT_STRING_SIZE]) {
  return On(instance, &Instance::ResultText, value, buffer);
}

XRAPI_ATTR XrResult XRAPI_CALL StructureTypeToString(XrInstance instance, XrStructureType value,
                                                     char buffer[XR_MAX_STRUCTURE_NAME_SIZE]) {
  return On(instance, &Instance::StructureTypeText, value, buffer);
}

XRAPI_ATTR XrResult XRAPI_CALL EnumerateApiLayerProperties(uint32_t capacity, uint32_t* count,
                                                           XrApiLayerProperties* properties) {
  return Guarded([&] { return EnumerateLayers(capacity, count, properties); });
}

XRAPI_ATTR XrResult XRAPI_CALL EnumerateInstanceExtensionProperties(const char* layer_name, uint32_t capacity,
                                                                    uint32_t* count,
                                                                    XrExtensionProperties* properties) {
  return Guarded([&] { return EnumerateExtensions(layer_name, capacity, count, properties); });
}

XRAPI_ATTR XrResult XRAPI_CALL CreateApiLayerInstanceEntry(const XrInstanceCreateInfo* info,
                                                           const XrApiLayerCreateInfo* layer_info,
                                                           XrInstance* instance) {
  return Guarded([&] { return CreateApiLayerInstance(info, layer_info, instance); });
}

XRAPI_ATTR XrResult XRAPI_CALL GetInstanceProcAddr(XrInstance instance, const char* name,
                                                   PFN_xrVoidFunction* function) {
  return Guarded([&] {
    if (!name || !function) return XR_ERROR_VALIDATION_FAILURE;
    const auto record = Registry::Get().Find(instance);
    *function = FindIntercepted(name, record ? &record->next : nullptr);
    if (*function) return XR_SUCCESS;
    if (!record) return XR_ERROR_HANDLE_INVALID;
    for (const OwnFunction& own : OwnFunctions()) {
      if (std::strcmp(name, own.name) != 0) continue;
      const bool enabled = record->Enabled(own.extension);
      if (!enabled || (own.also && !record->Enabled(own.also))) return XR_ERROR_FUNCTION_UNSUPPORTED;
      *function = own.function;
      return XR_SUCCESS;
    }
    // Enabled for our own use: to the application it is not there.
    if (record->hide_timespec && (std::strcmp(name, "xrConvertTimespecTimeToTimeKHR") == 0 ||
                                  std::strcmp(name, "xrConvertTimeToTimespecTimeKHR") == 0))
      return XR_ERROR_FUNCTION_UNSUPPORTED;
    return record->next.GetInstanceProcAddr(instance, name, function);
  });
}

}  // namespace

PFN_xrVoidFunction FindIntercepted(const char* name, [[maybe_unused]] const Dispatch* below) {
#define OMNI_LAYER_ROW(function) \
  if (std::strcmp(name, "xr" #function) == 0) return Erase(&(function));
  OMNI_LAYER_INTERCEPTED(OMNI_LAYER_ROW)
  OMNI_LAYER_ROW(GetInstanceProcAddr)
  OMNI_LAYER_ROW(EnumerateApiLayerProperties)
  OMNI_LAYER_ROW(EnumerateInstanceExtensionProperties)
#undef OMNI_LAYER_ROW
#define OMNI_LAYER_ROW(function) \
  if (below && below->function && std::strcmp(name, "xr" #function) == 0) return Erase(&(function));
  OMNI_LAYER_OPTIONAL(OMNI_LAYER_ROW)
#undef OMNI_LAYER_ROW
  return nullptr;
}

namespace {

template <class Function>
bool Load(XrInstance instance, PFN_xrGetInstanceProcAddr get, const char* name, Function& function) {
  PFN_xrVoidFunction found = nullptr;
  if (XR_FAILED(get(instance, name, &found))) found = nullptr;
  function = reinterpret_cast<Function>(found);
  return found != nullptr;
}

}  // namespace

bool LoadDispatch(XrInstance instance, PFN_xrGetInstanceProcAddr next_get, Dispatch& next, const char** missing) {
  next.GetInstanceProcAddr = next_get;
  bool complete = true;
#define OMNI_LAYER_LOAD(name)                             \
  if (!Load(instance, next_get, "xr" #name, next.name)) { \
    complete = false;                                     \
    *missing = "xr" #name;                                \
  }
  OMNI_LAYER_INTERCEPTED(OMNI_LAYER_LOAD)
  OMNI_LAYER_CALLED(OMNI_LAYER_LOAD)
#undef OMNI_LAYER_LOAD
#define OMNI_LAYER_LOAD(name) Load(instance, next_get, "xr" #name, next.name);
  OMNI_LAYER_OPTIONAL(OMNI_LAYER_LOAD)
#undef OMNI_LAYER_LOAD
  Load(instance, next_get, "xrConvertTimespecTimeToTimeKHR", next.ConvertTimespecTimeToTimeKHR);
  Load(instance, next_get, "xrEnumerateInstanceExtensionProperties", next.EnumerateInstanceExtensionProperties);
  return complete;
}

}  // namespace omni::layer

extern "C" XRAPI_ATTR __attribute__((visibility("default"))) XrResult XRAPI_CALL xrNegotiateLoaderApiLayerInterface(
    const XrNegotiateLoaderInfo* loader, const char* layer_name, XrNegotiateApiLayerRequest* request) {
  using namespace omni::layer;
  if (!loader || !request || loader->structType != XR_LOADER_INTERFACE_STRUCT_LOADER_INFO ||
      loader->structVersion != kLoaderInfoVersion || loader->structSize < sizeof(XrNegotiateLoaderInfo) ||
      request->structType != XR_LOADER_INTERFACE_STRUCT_API_LAYER_REQUEST ||
      request->structVersion != kApiLayerRequestVersion || request->structSize < sizeof(XrNegotiateApiLayerRequest))
    return XR_ERROR_INITIALIZATION_FAILED;
  if (layer_name && std::strcmp(layer_name, kLayerName) != 0) return XR_ERROR_INITIALIZATION_FAILED;
  // What we need is OpenXR 1.0; a loader or application of any 1.x works with us.
  const XrVersion ours = XR_MAKE_VERSION(1, 0, 0);
  if (!(loader->minInterfaceVersion <= kLoaderApiLayerInterfaceVersion &&
        loader->maxInterfaceVersion >= kLoaderApiLayerInterfaceVersion && loader->minApiVersion <= ours &&
        loader->maxApiVersion >= ours))
    return XR_ERROR_INITIALIZATION_FAILED;
  request->layerInterfaceVersion = kLoaderApiLayerInterfaceVersion;
  request->layerApiVersion = XR_MAKE_VERSION(1, 0, 20);
  request->getInstanceProcAddr = &GetInstanceProcAddr;
  request->createApiLayerInstance = &CreateApiLayerInstanceEntry;
  return XR_SUCCESS;
}
