// The steps that lead to a Vulkan binding, of either extension.

#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <dlfcn.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <mutex>

#include "tests/runtime/graphics/vulkan.h"
#include "tests/runtime/graphics/vulkan_device.h"
#include "tests/runtime/state.h"
#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

// Of the instances that an application makes itself. Never closed: they outlive this runtime.
PFN_vkGetInstanceProcAddr SystemLoader() {
  static void* const library = dlopen("libvulkan.so.1", RTLD_NOW);
  if (library == nullptr) return nullptr;
  return reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"));
}

PFN_vkGetInstanceProcAddr LoaderOf(const Instance& instance) {
  if (instance.vulkan.get_instance_proc == nullptr) return SystemLoader();
  return reinterpret_cast<PFN_vkGetInstanceProcAddr>(instance.vulkan.get_instance_proc);
}

XrResult GetVulkanGraphicsRequirements(XrInstance instance, XrSystemId system, XrGraphicsRequirementsVulkanKHR* out) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(out, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  out->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
  out->maxApiVersionSupported = XR_MAKE_VERSION(1, 3, 0);
  owner->vulkan.asked = true;
  return XR_SUCCESS;
}

// No Vulkan extension is needed: an empty list.
XrResult GetVulkanExtensions(XrInstance instance, XrSystemId system, uint32_t capacity, uint32_t* count, char* names) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  return TwoCallString("", capacity, count, names);
}

// A device in software where there is one, so that tests are the same on every machine; else the first.
XrResult ChooseDevice(Instance& owner, VkInstance instance, VkPhysicalDevice* chosen) {
  const VulkanInstanceFunctions vk(LoaderOf(owner), instance);
  OMNI_REQUIRE(vk.complete, XR_ERROR_RUNTIME_FAILURE);
  VkPhysicalDevice devices[16] = {};
  auto count = static_cast<uint32_t>(std::size(devices));
  OMNI_REQUIRE(vk.EnumeratePhysicalDevices(instance, &count, devices) >= VK_SUCCESS && count > 0,
               XR_ERROR_RUNTIME_FAILURE);
  *chosen = devices[0];
  for (uint32_t i = count; i-- > 0;) {
    VkPhysicalDeviceProperties properties{};
    vk.GetPhysicalDeviceProperties(devices[i], &properties);
    if (properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) *chosen = devices[i];
  }
  owner.vulkan.physical_device = *chosen;
  return XR_SUCCESS;
}

XrResult GetVulkanGraphicsDevice(XrInstance instance, XrSystemId system, VkInstance vulkan, VkPhysicalDevice* device) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(vulkan != VK_NULL_HANDLE && device != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  return ChooseDevice(*owner, vulkan, device);
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
  OMNI_REQUIRE(owner->vulkan.asked, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  const auto create =
      reinterpret_cast<PFN_vkCreateInstance>(info->pfnGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance"));
  *result = create(info->vulkanCreateInfo, info->vulkanAllocator, made);
  if (*result != VK_SUCCESS) return XR_SUCCESS;
  owner->vulkan.get_instance_proc = reinterpret_cast<PFN_xrVoidFunction>(info->pfnGetInstanceProcAddr);
  owner->vulkan.instance = *made;
  return XR_SUCCESS;
}

XrResult GetVulkanGraphicsDevice2(XrInstance instance, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                  VkPhysicalDevice* device) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR) && device != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->systemId == kSystemId, XR_ERROR_SYSTEM_INVALID);
  OMNI_REQUIRE(owner->vulkan.instance != nullptr && info->vulkanInstance == owner->vulkan.instance,
               XR_ERROR_VALIDATION_FAILURE);
  return ChooseDevice(*owner, info->vulkanInstance, device);
}

XrResult CreateVulkanDevice(XrInstance instance, const XrVulkanDeviceCreateInfoKHR* info, VkDevice* made,
                            VkResult* result) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR) && made != nullptr && result != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->systemId == kSystemId, XR_ERROR_SYSTEM_INVALID);
  OMNI_REQUIRE(info->vulkanCreateInfo != nullptr && info->pfnGetInstanceProcAddr != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(owner->vulkan.instance != nullptr && info->vulkanPhysicalDevice != VK_NULL_HANDLE &&
                   info->vulkanPhysicalDevice == owner->vulkan.physical_device,
               XR_ERROR_HANDLE_INVALID);
  const auto create = reinterpret_cast<PFN_vkCreateDevice>(
      info->pfnGetInstanceProcAddr(static_cast<VkInstance>(owner->vulkan.instance), "vkCreateDevice"));
  *result = create(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, made);
  return XR_SUCCESS;
}

struct NamedFunction {
  std::string_view name;
  PFN_xrVoidFunction function;
};

template <class Function>
PFN_xrVoidFunction Untyped(Function function) {
  return reinterpret_cast<PFN_xrVoidFunction>(function);
}

const NamedFunction kEnable[] = {
    {"xrGetVulkanGraphicsRequirementsKHR", Untyped(&GetVulkanGraphicsRequirements)},
    {"xrGetVulkanInstanceExtensionsKHR", Untyped(&GetVulkanExtensions)},
    {"xrGetVulkanDeviceExtensionsKHR", Untyped(&GetVulkanExtensions)},
    {"xrGetVulkanGraphicsDeviceKHR", Untyped(&GetVulkanGraphicsDevice)},
};
const NamedFunction kEnable2[] = {
    {"xrGetVulkanGraphicsRequirements2KHR", Untyped(&GetVulkanGraphicsRequirements)},
    {"xrCreateVulkanInstanceKHR", Untyped(&CreateVulkanInstance)},
    {"xrGetVulkanGraphicsDevice2KHR", Untyped(&GetVulkanGraphicsDevice2)},
    {"xrCreateVulkanDeviceKHR", Untyped(&CreateVulkanDevice)},
};

template <size_t size>
PFN_xrVoidFunction FindIn(const NamedFunction (&functions)[size], std::string_view name) {
  for (const NamedFunction& known : functions) {
    if (known.name == name) return known.function;
  }
  return nullptr;
}

}  // namespace

std::vector<GraphicsExtension> VulkanExtensions() {
  return {{XR_KHR_VULKAN_ENABLE_EXTENSION_NAME, XR_KHR_vulkan_enable_SPEC_VERSION},
          {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, XR_KHR_vulkan_enable2_SPEC_VERSION}};
}

PFN_xrVoidFunction FindVulkanFunction(const Instance& instance, std::string_view name) {
  PFN_xrVoidFunction found = nullptr;
  if (instance.Enabled(XR_KHR_VULKAN_ENABLE_EXTENSION_NAME)) found = FindIn(kEnable, name);
  if (found == nullptr && instance.Enabled(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME)) found = FindIn(kEnable2, name);
  return found;
}

XrResult CreateVulkanGraphics(const Instance& instance, const void* chain, std::shared_ptr<Graphics>* graphics) {
  const auto& binding = *static_cast<const XrGraphicsBindingVulkanKHR*>(chain);
  const bool enable = instance.Enabled(XR_KHR_VULKAN_ENABLE_EXTENSION_NAME);
  OMNI_REQUIRE(enable || instance.Enabled(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  OMNI_REQUIRE(instance.vulkan.asked, XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  const bool made_here = instance.vulkan.instance != nullptr && binding.instance == instance.vulkan.instance;
  OMNI_REQUIRE(binding.instance != VK_NULL_HANDLE && (enable || made_here), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  OMNI_REQUIRE(binding.physicalDevice != VK_NULL_HANDLE && binding.physicalDevice == instance.vulkan.physical_device &&
                   binding.device != VK_NULL_HANDLE,
               XR_ERROR_GRAPHICS_DEVICE_INVALID);
  return CreateVulkanDeviceGraphics(LoaderOf(instance), binding, graphics);
}

}  // namespace omni::runtime
