#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <mutex>

#include "tests/runtime/frame/vulkan.h"
#include "tests/runtime/state.h"
#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

template <class Function>
Function VulkanFunction(PFN_vkGetInstanceProcAddr get, VkInstance instance, const char* name) {
  return reinterpret_cast<Function>(get(instance, name));
}

XrResult GetVulkanGraphicsRequirements2(XrInstance instance, XrSystemId system, XrGraphicsRequirementsVulkanKHR* out) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(out, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  out->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
  out->maxApiVersionSupported = XR_MAKE_VERSION(1, 3, 0);
  owner->vulkan_asked = true;
  return XR_SUCCESS;
}

XrResult CreateVulkanInstance(XrInstance instance, const XrVulkanInstanceCreateInfoKHR* info, VkInstance* made,
                              VkResult* result) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR) && made != nullptr && result != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->systemId == kSystemId, XR_ERROR_SYSTEM_INVALID);
  OMNI_REQUIRE(info->pfnGetInstanceProcAddr != nullptr && info->vulkanCreateInfo != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(owner->vulkan_asked, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  owner->vulkan_get = reinterpret_cast<PFN_xrVoidFunction>(info->pfnGetInstanceProcAddr);
  const auto create =
      VulkanFunction<PFN_vkCreateInstance>(info->pfnGetInstanceProcAddr, VK_NULL_HANDLE, "vkCreateInstance");
  *result = create(info->vulkanCreateInfo, info->vulkanAllocator, made);
  if (*result == VK_SUCCESS) owner->vulkan_instance = *made;
  return XR_SUCCESS;
}

XrResult GetVulkanGraphicsDevice2(XrInstance instance, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                  VkPhysicalDevice* device) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR) && device != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->systemId == kSystemId, XR_ERROR_SYSTEM_INVALID);
  OMNI_REQUIRE(owner->vulkan_instance != nullptr && info->vulkanInstance == owner->vulkan_instance,
               XR_ERROR_VALIDATION_FAILURE);
  const auto get = reinterpret_cast<PFN_vkGetInstanceProcAddr>(owner->vulkan_get);
  const auto enumerate =
      VulkanFunction<PFN_vkEnumeratePhysicalDevices>(get, info->vulkanInstance, "vkEnumeratePhysicalDevices");
  uint32_t count = 1;
  const VkResult result = enumerate(info->vulkanInstance, &count, device);
  return result >= VK_SUCCESS && count == 1 ? XR_SUCCESS : XR_ERROR_RUNTIME_FAILURE;
}

XrResult CreateVulkanDevice(XrInstance instance, const XrVulkanDeviceCreateInfoKHR* info, VkDevice* made,
                            VkResult* result) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR) && made != nullptr && result != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->systemId == kSystemId, XR_ERROR_SYSTEM_INVALID);
  OMNI_REQUIRE(owner->vulkan_instance != nullptr && info->vulkanPhysicalDevice != VK_NULL_HANDLE &&
                   info->vulkanCreateInfo != nullptr && info->pfnGetInstanceProcAddr != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  const auto create = VulkanFunction<PFN_vkCreateDevice>(
      info->pfnGetInstanceProcAddr, static_cast<VkInstance>(owner->vulkan_instance), "vkCreateDevice");
  *result = create(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, made);
  return XR_SUCCESS;
}

template <class Function>
PFN_xrVoidFunction Untyped(Function function) {
  return reinterpret_cast<PFN_xrVoidFunction>(function);
}

}  // namespace

const char* VulkanExtension() { return XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME; }

PFN_xrVoidFunction FindVulkanFunction(std::string_view name) {
  if (name == "xrGetVulkanGraphicsRequirements2KHR") return Untyped(&GetVulkanGraphicsRequirements2);
  if (name == "xrCreateVulkanInstanceKHR") return Untyped(&CreateVulkanInstance);
  if (name == "xrGetVulkanGraphicsDevice2KHR") return Untyped(&GetVulkanGraphicsDevice2);
  if (name == "xrCreateVulkanDeviceKHR") return Untyped(&CreateVulkanDevice);
  return nullptr;
}

XrResult CheckVulkanBinding(const Instance& instance, const void* chain) {
  const auto* binding = static_cast<const XrGraphicsBindingVulkanKHR*>(chain);
  OMNI_REQUIRE(instance.vulkan && binding != nullptr && binding->type == XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR,
               XR_ERROR_GRAPHICS_DEVICE_INVALID);
  OMNI_REQUIRE(instance.vulkan_asked, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  OMNI_REQUIRE(binding->instance != VK_NULL_HANDLE && binding->instance == instance.vulkan_instance &&
                   binding->physicalDevice != VK_NULL_HANDLE && binding->device != VK_NULL_HANDLE,
               XR_ERROR_GRAPHICS_DEVICE_INVALID);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
