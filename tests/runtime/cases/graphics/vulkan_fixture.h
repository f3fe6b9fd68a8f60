#pragma once
// An application with a Vulkan device. Its tests are skipped where there is none (mesa-vulkan-drivers has one in
// software).

#include <vulkan/vulkan.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <string>
#include <vector>

#include "tests/runtime/cases/fixture.h"

namespace omni::runtime {

class VulkanTest : public RuntimeTest {
 protected:
  // An instance with both extensions of Vulkan and depth layers; device and session by XR_KHR_vulkan_enable2.
  void SetUp() override;
  void TearDown() override;

  template <class Function>
  Function Load(const char* name) {
    PFN_xrVoidFunction found = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(instance_, name, &found), XR_SUCCESS) << name;
    return reinterpret_cast<Function>(found);
  }

  void StartVulkan(const std::vector<const char*>& extensions);
  XrResult AskRequirements();
  XrResult MakeVulkanInstance(VkResult* result);
  XrResult ChooseDevice();
  XrResult MakeDevice(VkPhysicalDevice physical, VkResult* result);
  XrResult CreateSession(const void* chain, XrSession* session);
  void DestroyVulkan();

  // 64 x 48 texels in two arrays.
  XrSwapchainCreateInfo ColorInfo();
  XrSwapchain AddSwapchain(const XrSwapchainCreateInfo& info);
  std::vector<XrSwapchainImageVulkanKHR> Images(XrSwapchain swapchain);
  XrResult Acquire(XrSwapchain swapchain, uint32_t* index = nullptr);
  XrResult Wait(XrSwapchain swapchain, XrDuration timeout = 0);
  XrResult Release(XrSwapchain swapchain) { return xrReleaseSwapchainImage(swapchain, nullptr); }
  // Acquire, wait, release. With two colours, of two arrays, the upper left quarter of the first is filled with that of
  // the second.
  void Show(XrSwapchain swapchain, const std::vector<VkClearColorValue>& colors = {});

  // To FOCUSED, with empty frames.
  void RunToFocus();
  XrTime BeginFrame();
  XrResult EndFrame(XrTime time, const std::vector<const void*>& layers);

  VkInstance vulkan_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  XrGraphicsBindingVulkan2KHR binding_{XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR};
};

}  // namespace omni::runtime
