#include "tests/runtime/frame/vulkan.h"

namespace omni::runtime {

const char* VulkanExtension() { return nullptr; }
PFN_xrVoidFunction FindVulkanFunction(std::string_view) { return nullptr; }
XrResult CheckVulkanBinding(const Instance&, const void*) { return XR_ERROR_GRAPHICS_DEVICE_INVALID; }

}  // namespace omni::runtime
