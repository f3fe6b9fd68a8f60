// Every function that an application or the loader can call: finds the instance and stops exceptions. Instance
// and its parts do the work, one class per subject.
#include <cstring>
#include <optional>

#include "layer/src/entry/create_instance.h"
#include "layer/src/entry/guarded.h"
#include "layer/src/entry/own_extensions.h"

namespace omni::layer {
namespace {

XRAPI_ATTR XrResult XRAPI_CALL DestroyInstance(XrInstance instance) {
  return Guarded([&] {
    const auto record = Registry::Get().Find(instance);
    if (const auto aside = Registry::Get().FindAside(instance)) {
      const XrResult result = aside->destroy ? aside->destroy(instance) : XR_ERROR_RUNTIME_FAILURE;
      if (XR_SUCCEEDED(result)) Registry::Get().Remove(instance);
      return result;
    }
    if (!record) return XR_ERROR_HANDLE_INVALID;
    record->link.SetSession(protocol::SessionState::kNone);
    const XrResult result = record->runtime.next.DestroyInstance(instance);
    if (XR_SUCCEEDED(result)) Registry::Get().Remove(instance);
    return result;
  });
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

// Of the extension that we enable for ourselves: hidden from an application that did not.
bool ConvertsTime(const char* name) {
  return std::strcmp(name, "xrConvertTimespecTimeToTimeKHR") == 0 ||
         std::strcmp(name, "xrConvertTimeToTimespecTimeKHR") == 0;
}

XRAPI_ATTR XrResult XRAPI_CALL GetInstanceProcAddr(XrInstance instance, const char* name,
                                                   PFN_xrVoidFunction* function) {
  return Guarded([&] {
    if (!name || !function) return XR_ERROR_VALIDATION_FAILURE;
    const auto record = Registry::Get().Find(instance);
    if (const auto aside = record ? std::nullopt : Registry::Get().FindAside(instance);
        aside && std::strcmp(name, "xrDestroyInstance") != 0) {
      *function = nullptr;
      if (aside->hide_timespec && ConvertsTime(name)) return XR_ERROR_FUNCTION_UNSUPPORTED;
      return aside->get(instance, name, function);
    }
    *function = FindIntercepted(name, record ? &record->runtime.next : nullptr);
    if (*function) return XR_SUCCESS;
    if (!record) return XR_ERROR_HANDLE_INVALID;
    for (const OwnFunction& own : OwnFunctions()) {
      if (std::strcmp(name, own.name) != 0) continue;
      if (!record->runtime.HasExtension(own.extension)) return XR_ERROR_FUNCTION_UNSUPPORTED;
      *function = own.function;
      return XR_SUCCESS;
    }
    if (record->hide_timespec && ConvertsTime(name)) return XR_ERROR_FUNCTION_UNSUPPORTED;
    return record->runtime.next.GetInstanceProcAddr(instance, name, function);
  });
}

}  // namespace

PFN_xrVoidFunction FindIntercepted(const char* name, const Dispatch* below) {
#define OMNI_LAYER_OWN(function) \
  if (std::strcmp(name, "xr" #function) == 0) return Erase(&(function));
  OMNI_LAYER_OWN(DestroyInstance)
  OMNI_LAYER_OWN(GetInstanceProcAddr)
  OMNI_LAYER_OWN(EnumerateApiLayerProperties)
  OMNI_LAYER_OWN(EnumerateInstanceExtensionProperties)
#undef OMNI_LAYER_OWN
#define OMNI_LAYER_ROW(part, function) \
  if (std::strcmp(name, "xr" #function) == 0) return Erase(&Entry<PFN_xr##function, &part::function>::Call);
  OMNI_LAYER_INTERCEPTED(OMNI_LAYER_ROW)
#undef OMNI_LAYER_ROW
#define OMNI_LAYER_ROW(part, function)                                    \
  if (below && below->function && std::strcmp(name, "xr" #function) == 0) \
    return Erase(&Entry<PFN_xr##function, &part::function>::Call);
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
#define OMNI_LAYER_LOAD(part, name)                       \
  if (!Load(instance, next_get, "xr" #name, next.name)) { \
    complete = false;                                     \
    *missing = "xr" #name;                                \
  }
  OMNI_LAYER_INTERCEPTED(OMNI_LAYER_LOAD)
  OMNI_LAYER_CALLED(OMNI_LAYER_LOAD)
#undef OMNI_LAYER_LOAD
#define OMNI_LAYER_LOAD(part, name) Load(instance, next_get, "xr" #name, next.name);
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
  // We need OpenXR 1.0; loaders and applications of any 1.x work with us.
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
