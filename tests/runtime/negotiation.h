#pragma once
// The structures by which the OpenXR loader meets a runtime. Debian's libopenxr-dev does not ship the header that
// declares them, so they are declared here from the loader specification (chapter "Loader design: runtime interface
// negotiation"); the sizes are what the loader checks.

#include <openxr/openxr.h>

#include <cstddef>
#include <cstdint>

namespace omni::runtime {

inline constexpr uint32_t kLoaderInfoType = 1;      // XR_LOADER_INTERFACE_STRUCT_LOADER_INFO
inline constexpr uint32_t kRuntimeRequestType = 3;  // XR_LOADER_INTERFACE_STRUCT_RUNTIME_REQUEST
inline constexpr uint32_t kStructVersion = 1;
inline constexpr uint32_t kInterfaceVersion = 1;

struct NegotiateLoaderInfo {
  uint32_t struct_type;
  uint32_t struct_version;
  size_t struct_size;
  uint32_t min_interface_version;
  uint32_t max_interface_version;
  XrVersion min_api_version;
  XrVersion max_api_version;
};
static_assert(sizeof(NegotiateLoaderInfo) == 40);

struct NegotiateRuntimeRequest {
  uint32_t struct_type;
  uint32_t struct_version;
  size_t struct_size;
  uint32_t runtime_interface_version;
  XrVersion runtime_api_version;
  PFN_xrGetInstanceProcAddr get_instance_proc_addr;
};
static_assert(sizeof(NegotiateRuntimeRequest) == 40);

}  // namespace omni::runtime
