// Another layer for the tests of ours, which does what breaks layers with global state: inside its own
// xrCreateApiLayerInstance it first makes a second, dummy instance of everything below, calls it, and destroys it; with
// OMNI_OTHER_LAYER=keep only when the real one is destroyed.
#include <cstdlib>
#include <cstring>

#include "layer/src/entry/loader_interface.h"

namespace {

struct Kept {
  PFN_xrGetInstanceProcAddr next = nullptr;
  XrInstance dummy = XR_NULL_HANDLE;
};
Kept kept;

template <class Function>
Function Below(XrInstance instance, const char* name) {
  PFN_xrVoidFunction function = nullptr;
  return XR_SUCCEEDED(kept.next(instance, name, &function)) ? reinterpret_cast<Function>(function) : nullptr;
}

void Ask(XrInstance dummy) {
  const auto get_system = Below<PFN_xrGetSystem>(dummy, "xrGetSystem");
  const auto properties_of = Below<PFN_xrGetSystemProperties>(dummy, "xrGetSystemProperties");
  if (!get_system || !properties_of) return;
  const XrSystemGetInfo info{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  XrSystemId system = XR_NULL_SYSTEM_ID;
  XrSystemProperties properties{XR_TYPE_SYSTEM_PROPERTIES, nullptr, 0, 0, "", {}, {}};
  if (XR_SUCCEEDED(get_system(dummy, &info, &system))) properties_of(dummy, system, &properties);
}

void DropDummy() {
  const XrInstance dummy = kept.dummy;
  kept.dummy = XR_NULL_HANDLE;
  if (dummy == XR_NULL_HANDLE) return;
  if (const auto destroy = Below<PFN_xrDestroyInstance>(dummy, "xrDestroyInstance")) destroy(dummy);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroyInstance(XrInstance instance) {
  const auto destroy = Below<PFN_xrDestroyInstance>(instance, "xrDestroyInstance");
  if (!destroy) return XR_ERROR_HANDLE_INVALID;
  const XrResult result = destroy(instance);
  DropDummy();
  return result;
}

XRAPI_ATTR XrResult XRAPI_CALL GetInstanceProcAddr(XrInstance instance, const char* name,
                                                   PFN_xrVoidFunction* function) {
  if (name && function && std::strcmp(name, "xrDestroyInstance") == 0) {
    *function = reinterpret_cast<PFN_xrVoidFunction>(&DestroyInstance);
    return XR_SUCCESS;
  }
  return kept.next ? kept.next(instance, name, function) : XR_ERROR_HANDLE_INVALID;
}

XRAPI_ATTR XrResult XRAPI_CALL CreateApiLayerInstance(const XrInstanceCreateInfo* info,
                                                      const XrApiLayerCreateInfo* layer_info, XrInstance* instance) {
  const XrApiLayerNextInfo* next = layer_info->nextInfo;
  kept.next = next->nextGetInstanceProcAddr;
  XrApiLayerCreateInfo below = *layer_info;
  below.nextInfo = next->next;
  XrResult result = next->nextCreateApiLayerInstance(info, &below, &kept.dummy);
  if (XR_FAILED(result)) return result;
  Ask(kept.dummy);
  const char* habit = std::getenv("OMNI_OTHER_LAYER");
  if (!habit || std::strcmp(habit, "keep") != 0) DropDummy();
  result = next->nextCreateApiLayerInstance(info, &below, instance);
  if (XR_FAILED(result)) DropDummy();
  return result;
}

}  // namespace

extern "C" XRAPI_ATTR __attribute__((visibility("default"))) XrResult XRAPI_CALL
xrNegotiateLoaderApiLayerInterface(const XrNegotiateLoaderInfo*, const char*, XrNegotiateApiLayerRequest* request) {
  request->layerInterfaceVersion = kLoaderApiLayerInterfaceVersion;
  request->layerApiVersion = XR_MAKE_VERSION(1, 0, 20);
  request->getInstanceProcAddr = &GetInstanceProcAddr;
  request->createApiLayerInstance = &CreateApiLayerInstance;
  return XR_SUCCESS;
}
