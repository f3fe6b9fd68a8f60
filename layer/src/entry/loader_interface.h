// The loader's negotiation interface (openxr_loader_negotiation.h of the OpenXR SDK, interface version 1), which
// Debian's libopenxr-dev does not ship. Sizes are checked by the loader, hence by us.
#pragma once

#include "layer/src/entry/omni_openxr_compat.h"

extern "C" {

enum XrLoaderInterfaceStructs {
  XR_LOADER_INTERFACE_STRUCT_UNINTIALIZED = 0,
  XR_LOADER_INTERFACE_STRUCT_LOADER_INFO = 1,
  XR_LOADER_INTERFACE_STRUCT_API_LAYER_REQUEST = 2,
  XR_LOADER_INTERFACE_STRUCT_RUNTIME_REQUEST = 3,
  XR_LOADER_INTERFACE_STRUCT_API_LAYER_CREATE_INFO = 4,
  XR_LOADER_INTERFACE_STRUCT_API_LAYER_NEXT_INFO = 5
};

inline constexpr uint32_t kLoaderInfoVersion = 1;
inline constexpr uint32_t kApiLayerRequestVersion = 1;
inline constexpr uint32_t kApiLayerCreateInfoVersion = 1;
inline constexpr uint32_t kApiLayerNextInfoVersion = 1;
inline constexpr uint32_t kLoaderApiLayerInterfaceVersion = 1;
inline constexpr size_t kApiLayerMaxSettingsPath = 512;

struct XrNegotiateLoaderInfo {
  XrLoaderInterfaceStructs structType;
  uint32_t structVersion;
  size_t structSize;
  uint32_t minInterfaceVersion;
  uint32_t maxInterfaceVersion;
  XrVersion minApiVersion;
  XrVersion maxApiVersion;
};

struct XrApiLayerCreateInfo;
typedef XrResult(XRAPI_PTR* PFN_xrCreateApiLayerInstance)(const XrInstanceCreateInfo* info,
                                                          const XrApiLayerCreateInfo* apiLayerInfo,
                                                          XrInstance* instance);

struct XrNegotiateApiLayerRequest {
  XrLoaderInterfaceStructs structType;
  uint32_t structVersion;
  size_t structSize;
  uint32_t layerInterfaceVersion;
  XrVersion layerApiVersion;
  PFN_xrGetInstanceProcAddr getInstanceProcAddr;
  PFN_xrCreateApiLayerInstance createApiLayerInstance;
};

struct XrApiLayerNextInfo {
  XrLoaderInterfaceStructs structType;
  uint32_t structVersion;
  size_t structSize;
  char layerName[XR_MAX_API_LAYER_NAME_SIZE];
  PFN_xrGetInstanceProcAddr nextGetInstanceProcAddr;
  PFN_xrCreateApiLayerInstance nextCreateApiLayerInstance;
  XrApiLayerNextInfo* next;
};

struct XrApiLayerCreateInfo {
  XrLoaderInterfaceStructs structType;
  uint32_t structVersion;
  size_t structSize;
  void* loaderInstance;
  char settings_file_location[kApiLayerMaxSettingsPath];
  XrApiLayerNextInfo* nextInfo;
};

static_assert(sizeof(XrNegotiateLoaderInfo) == 40);
static_assert(sizeof(XrNegotiateApiLayerRequest) == 48);
static_assert(sizeof(XrApiLayerCreateInfo) == 544);
static_assert(sizeof(XrApiLayerNextInfo) == 296);

}  // extern "C"
