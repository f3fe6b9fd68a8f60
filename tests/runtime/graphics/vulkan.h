#pragma once
// XR_KHR_vulkan_enable and XR_KHR_vulkan_enable2. What the second makes, it makes with the application's own loader;
// for the first, this runtime opens libvulkan.so.1 itself. Built without Vulkan's headers, there is neither.

#include <openxr/openxr.h>

#include <string_view>

#include "tests/runtime/graphics/graphics.h"

namespace omni::runtime {

std::vector<GraphicsExtension> VulkanExtensions();
PFN_xrVoidFunction FindVulkanFunction(const Instance& instance, std::string_view name);
XrResult CreateVulkanGraphics(const Instance& instance, const void* binding, std::shared_ptr<Graphics>* graphics);

}  // namespace omni::runtime
