#pragma once
// The images of a Vulkan session, on the application's own device and queue.

#include <vulkan/vulkan.h>

#ifndef XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_GRAPHICS_API_VULKAN
#endif
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "tests/runtime/graphics/graphics.h"

namespace omni::runtime {

#define OMNI_VULKAN_INSTANCE_FUNCTIONS(X)   \
  X(EnumeratePhysicalDevices)               \
  X(GetPhysicalDeviceProperties)            \
  X(GetPhysicalDeviceQueueFamilyProperties) \
  X(GetPhysicalDeviceImageFormatProperties) \
  X(GetPhysicalDeviceMemoryProperties)      \
  X(GetDeviceProcAddr)

struct VulkanInstanceFunctions {
  VulkanInstanceFunctions(PFN_vkGetInstanceProcAddr get, VkInstance instance);
  bool complete = false;
#define OMNI_MEMBER(name) PFN_vk##name name = nullptr;
  OMNI_VULKAN_INSTANCE_FUNCTIONS(OMNI_MEMBER)
#undef OMNI_MEMBER
};

XrResult CreateVulkanDeviceGraphics(PFN_vkGetInstanceProcAddr get, const XrGraphicsBindingVulkanKHR& binding,
                                    std::shared_ptr<Graphics>* graphics);

}  // namespace omni::runtime
