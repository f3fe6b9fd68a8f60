#include "tests/runtime/graphics/vulkan.h"

namespace omni::runtime {

std::vector<GraphicsExtension> VulkanExtensions() { return {}; }
PFN_xrVoidFunction FindVulkanFunction(const Instance&, std::string_view) { return nullptr; }
XrResult CreateVulkanGraphics(const Instance&, const void*, std::shared_ptr<Graphics>*) {
  return XR_ERROR_GRAPHICS_DEVICE_INVALID;
}

}  // namespace omni::runtime
