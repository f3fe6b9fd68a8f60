// The Vulkan half of a session. The runtime says which Vulkan it needs, and makes instance and device itself
// (XR_KHR_vulkan_enable2), so that the application knows nothing of its extensions.
#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "session/session.h"

namespace example {

struct Session::Vulkan {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  XrGraphicsBindingVulkan2KHR binding{XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR};

  ~Vulkan() {
    if (device != VK_NULL_HANDLE) vkDestroyDevice(device, nullptr);
    if (instance != VK_NULL_HANDLE) vkDestroyInstance(instance, nullptr);
  }
};

namespace {

template <class Function>
bool Load(XrInstance instance, const char* name, Function& function) {
  PFN_xrVoidFunction found = nullptr;
  if (XR_FAILED(xrGetInstanceProcAddr(instance, name, &found))) return false;
  function = reinterpret_cast<Function>(found);
  return true;
}

// The first queue family that can draw.
bool GraphicsQueue(VkPhysicalDevice device, std::uint32_t& family) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  for (family = 0; family < count; ++family)
    if ((families[family].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0) return true;
  return false;
}

struct EnableFunctions {
  PFN_xrGetVulkanGraphicsRequirements2KHR requirements = nullptr;
  PFN_xrCreateVulkanInstanceKHR create_instance = nullptr;
  PFN_xrGetVulkanGraphicsDevice2KHR get_device = nullptr;
  PFN_xrCreateVulkanDeviceKHR create_device = nullptr;

  bool LoadAll(XrInstance instance) {
    return Load(instance, "xrGetVulkanGraphicsRequirements2KHR", requirements) &&
           Load(instance, "xrCreateVulkanInstanceKHR", create_instance) &&
           Load(instance, "xrGetVulkanGraphicsDevice2KHR", get_device) &&
           Load(instance, "xrCreateVulkanDeviceKHR", create_device);
  }
};

}  // namespace

const char* Session::VulkanExtension() { return XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME; }

const void* Session::CreateVulkan(XrSystemId system) {
  vulkan_ = std::make_shared<Vulkan>();
  problem_ = "the runtime could not make a Vulkan device";
  EnableFunctions enable;
  XrGraphicsRequirementsVulkan2KHR needs{XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR, nullptr, 0, 0};
  if (!enable.LoadAll(instance_) || XR_FAILED(enable.requirements(instance_, system, &needs))) return nullptr;

  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "example", 1, nullptr, 0, 0};
  const XrVersion least = needs.minApiVersionSupported;  // as Vulkan packs versions: major << 22 | minor << 12
  application.apiVersion = static_cast<std::uint32_t>(XR_VERSION_MAJOR(least)) << 22 |
                           static_cast<std::uint32_t>(XR_VERSION_MINOR(least)) << 12;
  VkInstanceCreateInfo instance_info{
      VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, nullptr, 0, &application, 0, nullptr, 0, nullptr};
  XrVulkanInstanceCreateInfoKHR make_instance{
      XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR, nullptr, system, 0, &vkGetInstanceProcAddr, &instance_info, nullptr};
  VkResult vk = VK_SUCCESS;
  if (XR_FAILED(enable.create_instance(instance_, &make_instance, &vulkan_->instance, &vk)) || vk != VK_SUCCESS)
    return nullptr;
  XrVulkanGraphicsDeviceGetInfoKHR which{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, nullptr, system,
                                         vulkan_->instance};
  if (XR_FAILED(enable.get_device(instance_, &which, &vulkan_->physical))) return nullptr;

  const float priority = 0;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
  if (!GraphicsQueue(vulkan_->physical, queue.queueFamilyIndex)) return nullptr;
  VkDeviceCreateInfo device_info{
      VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, nullptr, 0, 1, &queue, 0, nullptr, 0, nullptr, nullptr};
  XrVulkanDeviceCreateInfoKHR make_device{XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR,
                                          nullptr,
                                          system,
                                          0,
                                          &vkGetInstanceProcAddr,
                                          vulkan_->physical,
                                          &device_info,
                                          nullptr};
  if (XR_FAILED(enable.create_device(instance_, &make_device, &vulkan_->device, &vk)) || vk != VK_SUCCESS)
    return nullptr;
  problem_.clear();
  vulkan_->binding.instance = vulkan_->instance;
  vulkan_->binding.physicalDevice = vulkan_->physical;
  vulkan_->binding.device = vulkan_->device;
  vulkan_->binding.queueFamilyIndex = queue.queueFamilyIndex;
  return &vulkan_->binding;
}

Session::~Session() {
  if (session_ != XR_NULL_HANDLE) xrDestroySession(session_);
}

}  // namespace example
