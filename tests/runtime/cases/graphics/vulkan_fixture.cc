#include "tests/runtime/cases/graphics/vulkan_fixture.h"

#include <dlfcn.h>

namespace omni::runtime {
namespace {

constexpr XrSystemId kSystem = 1;

}  // namespace

void VulkanTest::SetUp() {
  RuntimeTest::SetUp();
  // Kept open: unloaded, what the driver holds on to would look like a leak.
  dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_NODELETE);
  StartVulkan({XR_KHR_VULKAN_ENABLE_EXTENSION_NAME, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME,
               XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME, XR_KHR_COMPOSITION_LAYER_CUBE_EXTENSION_NAME});
  ASSERT_EQ(AskRequirements(), XR_SUCCESS);
  VkResult result = VK_SUCCESS;
  ASSERT_EQ(MakeVulkanInstance(&result), XR_SUCCESS);
  if (result != VK_SUCCESS || ChooseDevice() != XR_SUCCESS) GTEST_SKIP() << "no Vulkan device";
  ASSERT_EQ(MakeDevice(physical_, &result), XR_SUCCESS);
  ASSERT_EQ(result, VK_SUCCESS);
  ASSERT_EQ(CreateSession(&binding_, &session_), XR_SUCCESS);
}

void VulkanTest::TearDown() {
  RuntimeTest::TearDown();
  DestroyVulkan();
}

void VulkanTest::DestroyVulkan() {
  if (device_ != VK_NULL_HANDLE) vkDestroyDevice(device_, nullptr);
  if (vulkan_ != VK_NULL_HANDLE) vkDestroyInstance(vulkan_, nullptr);
  device_ = VK_NULL_HANDLE;
  vulkan_ = VK_NULL_HANDLE;
}

void VulkanTest::StartVulkan(const std::vector<const char*>& extensions) {
  ASSERT_EQ(CreateInstance(extensions), XR_SUCCESS);
  auto get = Make<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  ASSERT_EQ(xrGetSystem(instance_, &get, &system), XR_SUCCESS);
  ASSERT_EQ(system, kSystem);
}

XrResult VulkanTest::AskRequirements() {
  auto needs = Make<XrGraphicsRequirementsVulkan2KHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
  return Load<PFN_xrGetVulkanGraphicsRequirements2KHR>("xrGetVulkanGraphicsRequirements2KHR")(instance_, kSystem,
                                                                                              &needs);
}

XrResult VulkanTest::MakeVulkanInstance(VkResult* result) {
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.apiVersion = VK_API_VERSION_1_0;
  VkInstanceCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  create.pApplicationInfo = &application;
  auto info = Make<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
  info.systemId = kSystem;
  info.pfnGetInstanceProcAddr = &vkGetInstanceProcAddr;
  info.vulkanCreateInfo = &create;
  const auto make = Load<PFN_xrCreateVulkanInstanceKHR>("xrCreateVulkanInstanceKHR");
  const XrResult made = make(instance_, &info, &vulkan_, result);
  binding_.instance = vulkan_;
  return made;
}

XrResult VulkanTest::ChooseDevice() {
  auto info = Make<XrVulkanGraphicsDeviceGetInfoKHR>(XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
  info.systemId = kSystem;
  info.vulkanInstance = vulkan_;
  const auto get = Load<PFN_xrGetVulkanGraphicsDevice2KHR>("xrGetVulkanGraphicsDevice2KHR");
  const XrResult result = get(instance_, &info, &physical_);
  binding_.physicalDevice = physical_;
  return result;
}

// Family 0 of every driver in use can draw.
XrResult VulkanTest::MakeDevice(VkPhysicalDevice physical, VkResult* result) {
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
  VkDeviceCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  auto info = Make<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
  info.systemId = kSystem;
  info.pfnGetInstanceProcAddr = &vkGetInstanceProcAddr;
  info.vulkanPhysicalDevice = physical;
  info.vulkanCreateInfo = &create;
  const auto make = Load<PFN_xrCreateVulkanDeviceKHR>("xrCreateVulkanDeviceKHR");
  const XrResult made = make(instance_, &info, &device_, result);
  if (made == XR_SUCCESS && *result == VK_SUCCESS) vkGetDeviceQueue(device_, 0, 0, &queue_);
  binding_.device = device_;
  return made;
}

XrResult VulkanTest::CreateSession(const void* chain, XrSession* session) {
  auto info = Make<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  info.next = chain;
  info.systemId = kSystem;
  return xrCreateSession(instance_, &info, session);
}

XrSwapchainCreateInfo VulkanTest::ColorInfo() {
  auto info = Make<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
  info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT |
                    XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT;
  info.format = VK_FORMAT_R8G8B8A8_SRGB;
  info.sampleCount = info.faceCount = info.mipCount = 1;
  info.width = 64;
  info.height = 48;
  info.arraySize = 2;
  return info;
}

XrSwapchain VulkanTest::AddSwapchain(const XrSwapchainCreateInfo& info) {
  XrSwapchain swapchain = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateSwapchain(session_, &info, &swapchain), XR_SUCCESS);
  return swapchain;
}

std::vector<XrSwapchainImageVulkanKHR> VulkanTest::Images(XrSwapchain swapchain) {
  uint32_t count = 0;
  EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 0, &count, nullptr), XR_SUCCESS);
  std::vector<XrSwapchainImageVulkanKHR> images(count,
                                                Make<XrSwapchainImageVulkanKHR>(XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR));
  EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, count, &count,
                                       reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data())),
            XR_SUCCESS);
  return images;
}

XrResult VulkanTest::Acquire(XrSwapchain swapchain, uint32_t* index) {
  uint32_t any = 0;
  return xrAcquireSwapchainImage(swapchain, nullptr, index == nullptr ? &any : index);
}

XrResult VulkanTest::Wait(XrSwapchain swapchain, XrDuration timeout) {
  auto info = Make<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
  info.timeout = timeout;
  return xrWaitSwapchainImage(swapchain, &info);
}

namespace {

// Array i gets colors[i]; then the upper left quarter of the first gets the colour of the second.
void Fill(VkCommandBuffer commands, VkImage image, const XrSwapchainCreateInfo& info,
          const std::vector<VkClearColorValue>& colors) {
  VkImageMemoryBarrier barrier{};
  barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  barrier.srcAccessMask = barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  barrier.oldLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
  barrier.image = image;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
  const auto change = [&] {
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                         nullptr, 0, nullptr, 1, &barrier);
  };
  change();
  for (uint32_t i = 0; i < colors.size(); ++i) {
    const VkImageSubresourceRange array{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, i, 1};
    vkCmdClearColorImage(commands, image, VK_IMAGE_LAYOUT_GENERAL, &colors[i], 1, &array);
  }
  barrier.oldLayout = VK_IMAGE_LAYOUT_GENERAL;
  change();
  VkImageCopy quarter{};
  quarter.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 1};
  quarter.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  quarter.extent = {info.width / 2, info.height / 2, 1};
  vkCmdCopyImage(commands, image, VK_IMAGE_LAYOUT_GENERAL, image, VK_IMAGE_LAYOUT_GENERAL, 1, &quarter);
  barrier.newLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  change();
}

}  // namespace

void VulkanTest::Show(XrSwapchain swapchain, const std::vector<VkClearColorValue>& colors) {
  uint32_t index = 0;
  ASSERT_EQ(Acquire(swapchain, &index), XR_SUCCESS);
  ASSERT_EQ(Wait(swapchain), XR_SUCCESS);
  if (!colors.empty()) {
    const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, 0};
    VkCommandPool pool = VK_NULL_HANDLE;
    ASSERT_EQ(vkCreateCommandPool(device_, &pool_info, nullptr, &pool), VK_SUCCESS);
    const VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
                                               VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    VkCommandBuffer commands = VK_NULL_HANDLE;
    ASSERT_EQ(vkAllocateCommandBuffers(device_, &allocate, &commands), VK_SUCCESS);
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    ASSERT_EQ(vkBeginCommandBuffer(commands, &begin), VK_SUCCESS);
    Fill(commands, Images(swapchain)[index].image, ColorInfo(), colors);
    ASSERT_EQ(vkEndCommandBuffer(commands), VK_SUCCESS);
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    ASSERT_EQ(vkQueueSubmit(queue_, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
    ASSERT_EQ(vkQueueWaitIdle(queue_), VK_SUCCESS);
    vkDestroyCommandPool(device_, pool, nullptr);
  }
  ASSERT_EQ(Release(swapchain), XR_SUCCESS);
}

void VulkanTest::RunToFocus() {
  PollStates();
  auto info = Make<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  ASSERT_EQ(xrBeginSession(session_, &info), XR_SUCCESS);
  ASSERT_EQ(EndFrame(BeginFrame(), {}), XR_SUCCESS);
  ASSERT_EQ(PollStates(), (std::vector<XrSessionState>{XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE,
                                                       XR_SESSION_STATE_FOCUSED}));
}

XrTime VulkanTest::BeginFrame() {
  auto frame = Make<XrFrameState>(XR_TYPE_FRAME_STATE);
  EXPECT_EQ(xrWaitFrame(session_, nullptr, &frame), XR_SUCCESS);
  // XR_FRAME_DISCARDED: the runtime rejected the frame before.
  EXPECT_TRUE(XR_SUCCEEDED(xrBeginFrame(session_, nullptr)));
  return frame.predictedDisplayTime;
}

XrResult VulkanTest::EndFrame(XrTime time, const std::vector<const void*>& layers) {
  std::vector<const XrCompositionLayerBaseHeader*> headers;
  headers.reserve(layers.size());
  for (const void* layer : layers) headers.push_back(static_cast<const XrCompositionLayerBaseHeader*>(layer));
  auto info = Make<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  info.displayTime = time;
  info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  info.layerCount = static_cast<uint32_t>(headers.size());
  info.layers = headers.data();
  return xrEndFrame(session_, &info);
}

}  // namespace omni::runtime
