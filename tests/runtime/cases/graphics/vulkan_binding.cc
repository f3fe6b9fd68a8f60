// The steps to a Vulkan session, and what happens if one is left out.

#include "tests/runtime/cases/graphics/vulkan_fixture.h"

namespace omni::runtime {
namespace {

constexpr XrSystemId kTheSystem = 1;

class VulkanBinding : public VulkanTest {};

TEST_F(VulkanBinding, SessionNeedsExactlyOneBinding) {
  XrSession session = XR_NULL_HANDLE;
  EXPECT_EQ(CreateSession(nullptr, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  XrGraphicsBindingVulkan2KHR second = binding_;
  second.next = &binding_;
  EXPECT_EQ(CreateSession(&second, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  // Of an API that this instance did not enable, alone or beside the right one.
  XrBaseOutStructure other{XR_TYPE_GRAPHICS_BINDING_D3D11_KHR, nullptr};
  EXPECT_EQ(CreateSession(&other, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  other.next = reinterpret_cast<XrBaseOutStructure*>(&binding_);
  EXPECT_EQ(CreateSession(&other, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  // A structure that is no binding may stand before it.
  other.type = XR_TYPE_SESSION_CREATE_INFO_OVERLAY_EXTX;
  EXPECT_EQ(CreateSession(&other, &session), XR_SUCCESS);
}

TEST_F(VulkanBinding, EveryHandleOfTheBindingMustBeTheRightOne) {
  XrSession session = XR_NULL_HANDLE;
  const auto changed = [this](auto change) {
    XrGraphicsBindingVulkan2KHR binding = binding_;
    change(binding);
    return binding;
  };
  const XrGraphicsBindingVulkan2KHR wrong[] = {
      changed([](auto& binding) { binding.instance = VK_NULL_HANDLE; }),
      changed([](auto& binding) { binding.physicalDevice = VK_NULL_HANDLE; }),
      changed([](auto& binding) { binding.physicalDevice = reinterpret_cast<VkPhysicalDevice>(binding.instance); }),
      changed([](auto& binding) { binding.device = VK_NULL_HANDLE; }),
      changed([](auto& binding) { binding.queueFamilyIndex = 1000; }),
      changed([](auto& binding) { binding.queueIndex = 1000; }),
  };
  for (const XrGraphicsBindingVulkan2KHR& binding : wrong)
    EXPECT_EQ(CreateSession(&binding, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID) << &binding - wrong;
  VkDevice device = VK_NULL_HANDLE;
  std::swap(device, device_);
  VkResult result = VK_SUCCESS;
  EXPECT_EQ(MakeDevice(VK_NULL_HANDLE, &result), XR_ERROR_HANDLE_INVALID);
  device_ = device;
}

TEST_F(VulkanBinding, RequirementsMustBeAskedForFirst) {
  const XrGraphicsBindingVulkan2KHR binding = binding_;
  DestroyInstance();
  StartVulkan({XR_KHR_VULKAN_ENABLE_EXTENSION_NAME, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME});
  EXPECT_EQ(CreateSession(&binding, &session_), XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  VkInstance vulkan = vulkan_;
  VkResult result = VK_SUCCESS;
  EXPECT_EQ(MakeVulkanInstance(&result), XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  vulkan_ = vulkan;
  auto needs = Make<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR);
  const auto ask = Load<PFN_xrGetVulkanGraphicsRequirementsKHR>("xrGetVulkanGraphicsRequirementsKHR");
  EXPECT_EQ(ask(instance_, kTheSystem + 1, &needs), XR_ERROR_SYSTEM_INVALID);
  EXPECT_EQ(CreateSession(&binding, &session_), XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  ASSERT_EQ(ask(instance_, kTheSystem, &needs), XR_SUCCESS);
  EXPECT_LE(needs.minApiVersionSupported, needs.maxApiVersionSupported);
  // The device was not asked for either.
  EXPECT_EQ(CreateSession(&binding, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
}

// XR_KHR_vulkan_enable: instance and device are the application's own.
TEST_F(VulkanBinding, FirstExtensionTakesObjectsOfTheApplication) {
  const XrGraphicsBindingVulkan2KHR binding = binding_;
  DestroyInstance();
  StartVulkan({XR_KHR_VULKAN_ENABLE_EXTENSION_NAME});
  PFN_xrVoidFunction none = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrCreateVulkanInstanceKHR", &none), XR_ERROR_FUNCTION_UNSUPPORTED);
  for (const char* name : {"xrGetVulkanInstanceExtensionsKHR", "xrGetVulkanDeviceExtensionsKHR"}) {
    const auto get = Load<PFN_xrGetVulkanInstanceExtensionsKHR>(name);
    uint32_t count = 0;
    char names[8] = "unset";
    ASSERT_EQ(get(instance_, kTheSystem, 0, &count, nullptr), XR_SUCCESS) << name;
    ASSERT_EQ(count, 1U) << name;
    EXPECT_EQ(get(instance_, kTheSystem, sizeof(names), &count, names), XR_SUCCESS) << name;
    EXPECT_STREQ(names, "") << name;
  }
  auto needs = Make<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR);
  ASSERT_EQ(
      Load<PFN_xrGetVulkanGraphicsRequirementsKHR>("xrGetVulkanGraphicsRequirementsKHR")(instance_, kTheSystem, &needs),
      XR_SUCCESS);
  const auto get = Load<PFN_xrGetVulkanGraphicsDeviceKHR>("xrGetVulkanGraphicsDeviceKHR");
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  EXPECT_EQ(get(instance_, kTheSystem, VK_NULL_HANDLE, &physical), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(get(instance_, kTheSystem, vulkan_, &physical), XR_SUCCESS);
  EXPECT_EQ(physical, physical_);
  EXPECT_EQ(CreateSession(&binding, &session_), XR_SUCCESS);
}

TEST_F(VulkanBinding, SecondExtensionAloneNeedsItsOwnInstance) {
  const XrGraphicsBindingVulkan2KHR binding = binding_;
  DestroyInstance();
  StartVulkan({XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME});
  PFN_xrVoidFunction none = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrGetVulkanGraphicsDeviceKHR", &none), XR_ERROR_FUNCTION_UNSUPPORTED);
  ASSERT_EQ(AskRequirements(), XR_SUCCESS);
  EXPECT_EQ(CreateSession(&binding, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
}

}  // namespace
}  // namespace omni::runtime
