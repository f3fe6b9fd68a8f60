#include "tests/runtime/graphics/vulkan_device.h"

#include <algorithm>
#include <utility>

#include "tests/runtime/graphics/texels.h"
#include "tests/runtime/state.h"

namespace omni::runtime {

VulkanInstanceFunctions::VulkanInstanceFunctions(PFN_vkGetInstanceProcAddr get, VkInstance instance) {
  if (get == nullptr) return;
#define OMNI_LOAD(name) name = reinterpret_cast<PFN_vk##name>(get(instance, "vk" #name));
  OMNI_VULKAN_INSTANCE_FUNCTIONS(OMNI_LOAD)
#undef OMNI_LOAD
#define OMNI_AND(name) &&(name) != nullptr
  complete = true OMNI_VULKAN_INSTANCE_FUNCTIONS(OMNI_AND);
#undef OMNI_AND
}

namespace {

#define OMNI_VULKAN_DEVICE_FUNCTIONS(X) \
  X(CreateImage)                        \
  X(DestroyImage)                       \
  X(GetImageMemoryRequirements)         \
  X(BindImageMemory)                    \
  X(CreateBuffer)                       \
  X(DestroyBuffer)                      \
  X(GetBufferMemoryRequirements)        \
  X(BindBufferMemory)                   \
  X(AllocateMemory)                     \
  X(FreeMemory)                         \
  X(MapMemory)                          \
  X(CreateCommandPool)                  \
  X(DestroyCommandPool)                 \
  X(AllocateCommandBuffers)             \
  X(BeginCommandBuffer)                 \
  X(EndCommandBuffer)                   \
  X(CmdPipelineBarrier)                 \
  X(CmdCopyImageToBuffer)               \
  X(GetDeviceQueue)                     \
  X(QueueSubmit)                        \
  X(CreateFence)                        \
  X(DestroyFence)                       \
  X(WaitForFences)

constexpr uint64_t kGiveUp_ns = 60'000'000'000;
constexpr uint32_t kTexelBytes = 4;

struct Format {
  VkFormat format;
  VkImageAspectFlags aspect;
  bool srgb;
  bool blue_first;

  bool depth() const { return aspect != VK_IMAGE_ASPECT_COLOR_BIT; }
  VkImageUsageFlags attachment() const {
    return depth() ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  }
  // In which the specification lets images pass between application and runtime.
  VkImageLayout layout() const {
    return depth() ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  }
};

// All of four bytes a texel where they have colours; the best first.
constexpr Format kFormats[] = {
    {VK_FORMAT_R8G8B8A8_SRGB, VK_IMAGE_ASPECT_COLOR_BIT, true, false},
    {VK_FORMAT_B8G8R8A8_SRGB, VK_IMAGE_ASPECT_COLOR_BIT, true, true},
    {VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_ASPECT_COLOR_BIT, false, false},
    {VK_FORMAT_B8G8R8A8_UNORM, VK_IMAGE_ASPECT_COLOR_BIT, false, true},
    {VK_FORMAT_D32_SFLOAT, VK_IMAGE_ASPECT_DEPTH_BIT, false, false},
    {VK_FORMAT_D16_UNORM, VK_IMAGE_ASPECT_DEPTH_BIT, false, false},
    {VK_FORMAT_D24_UNORM_S8_UINT, VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT, false, false},
    {VK_FORMAT_D32_SFLOAT_S8_UINT, VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT, false, false},
};

const Format* FindFormat(int64_t number) {
  const auto* const found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                         [number](const Format& known) { return known.format == number; });
  return found == std::end(kFormats) ? nullptr : found;
}

struct Usage {
  XrSwapchainUsageFlags bit;
  VkImageUsageFlags vulkan;
};
constexpr Usage kUsages[] = {
    {XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT},
    {XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT},
    {XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
    {XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_USAGE_TRANSFER_SRC_BIT},
    {XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT},
    {XR_SWAPCHAIN_USAGE_SAMPLED_BIT, VK_IMAGE_USAGE_SAMPLED_BIT},
};

VkImageCreateInfo ImageInfo(const XrSwapchainCreateInfo& info, const Format& format) {
  VkImageCreateInfo image{};
  image.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  if ((info.usageFlags & XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT) != 0) image.flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
  if (info.faceCount == 6) image.flags |= VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
  image.imageType = VK_IMAGE_TYPE_2D;
  image.format = format.format;
  image.extent = {info.width, info.height, 1};
  image.mipLevels = info.mipCount;
  image.arrayLayers = info.arraySize * info.faceCount;
  image.samples = VK_SAMPLE_COUNT_1_BIT;
  image.tiling = VK_IMAGE_TILING_OPTIMAL;
  image.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;  // for this runtime
  for (const Usage& usage : kUsages) {
    if ((info.usageFlags & usage.bit) != 0) image.usage |= usage.vulkan;
  }
  image.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  image.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
  return image;
}

struct VulkanDevice {
  VkDevice handle = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VulkanInstanceFunctions instance;
  uint32_t family = 0;
  VkQueue queue = VK_NULL_HANDLE;
  VkPhysicalDeviceMemoryProperties memory{};
#define OMNI_MEMBER(name) PFN_vk##name name = nullptr;
  OMNI_VULKAN_DEVICE_FUNCTIONS(OMNI_MEMBER)
#undef OMNI_MEMBER

  VulkanDevice(PFN_vkGetInstanceProcAddr get, const XrGraphicsBindingVulkanKHR& binding)
      : handle(binding.device), physical(binding.physicalDevice), instance(get, binding.instance) {}

  bool Load(const XrGraphicsBindingVulkanKHR& binding) {
    if (!instance.complete) return false;
#define OMNI_LOAD(name) name = reinterpret_cast<PFN_vk##name>(instance.GetDeviceProcAddr(handle, "vk" #name));
    OMNI_VULKAN_DEVICE_FUNCTIONS(OMNI_LOAD)
#undef OMNI_LOAD
#define OMNI_AND(name) &&(name) != nullptr
    const bool complete = true OMNI_VULKAN_DEVICE_FUNCTIONS(OMNI_AND);
#undef OMNI_AND
    if (!complete) return false;
    std::vector<VkQueueFamilyProperties> families(64);
    auto count = static_cast<uint32_t>(families.size());
    instance.GetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    family = binding.queueFamilyIndex;
    if (family >= count || binding.queueIndex >= families[family].queueCount) return false;
    if ((families[family].queueFlags & VK_QUEUE_GRAPHICS_BIT) == 0) return false;
    GetDeviceQueue(handle, family, binding.queueIndex, &queue);
    instance.GetPhysicalDeviceMemoryProperties(physical, &memory);
    return queue != VK_NULL_HANDLE;
  }

  // Null: no memory of that kind.
  VkDeviceMemory Allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags kind) const {
    for (uint32_t type = 0; type < memory.memoryTypeCount; ++type) {
      if ((needs.memoryTypeBits & 1U << type) == 0 || (memory.memoryTypes[type].propertyFlags & kind) != kind) continue;
      const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size, type};
      VkDeviceMemory made = VK_NULL_HANDLE;
      if (AllocateMemory(handle, &info, nullptr, &made) == VK_SUCCESS) return made;
    }
    return VK_NULL_HANDLE;
  }

  // Records, submits to the application's queue, and waits until it is done.
  template <class Record>
  bool Run(Record record) const {
    const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr,
                                            VK_COMMAND_POOL_CREATE_TRANSIENT_BIT, family};
    VkCommandPool pool = VK_NULL_HANDLE;
    if (CreateCommandPool(handle, &pool_info, nullptr, &pool) != VK_SUCCESS) return false;
    const bool done = RunIn(pool, record);
    DestroyCommandPool(handle, pool, nullptr);
    return done;
  }

 private:
  template <class Record>
  bool RunIn(VkCommandPool pool, Record record) const {
    const VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
                                               VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    VkCommandBuffer commands = VK_NULL_HANDLE;
    if (AllocateCommandBuffers(handle, &allocate, &commands) != VK_SUCCESS) return false;
    const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                         VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, nullptr};
    if (BeginCommandBuffer(commands, &begin) != VK_SUCCESS) return false;
    record(commands);
    if (EndCommandBuffer(commands) != VK_SUCCESS) return false;
    const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    VkFence fence = VK_NULL_HANDLE;
    if (CreateFence(handle, &fence_info, nullptr, &fence) != VK_SUCCESS) return false;
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    const bool done = QueueSubmit(queue, 1, &submit, fence) == VK_SUCCESS &&
                      WaitForFences(handle, 1, &fence, VK_TRUE, kGiveUp_ns) == VK_SUCCESS;
    DestroyFence(handle, fence, nullptr);
    return done;
  }
};

// A buffer that the processor can read.
class ReadBuffer {
 public:
  ReadBuffer(const VulkanDevice& device, VkDeviceSize size) : device_(device) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (device.CreateBuffer(device.handle, &info, nullptr, &buffer_) != VK_SUCCESS) return;
    VkMemoryRequirements needs{};
    device.GetBufferMemoryRequirements(device.handle, buffer_, &needs);
    memory_ = device.Allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    if (memory_ == VK_NULL_HANDLE || device.BindBufferMemory(device.handle, buffer_, memory_, 0) != VK_SUCCESS) return;
    void* mapped = nullptr;
    if (device.MapMemory(device.handle, memory_, 0, VK_WHOLE_SIZE, 0, &mapped) == VK_SUCCESS)
      bytes_ = static_cast<const uint8_t*>(mapped);
  }
  ReadBuffer(const ReadBuffer&) = delete;
  ReadBuffer& operator=(const ReadBuffer&) = delete;
  ~ReadBuffer() {
    device_.DestroyBuffer(device_.handle, buffer_, nullptr);
    device_.FreeMemory(device_.handle, memory_, nullptr);
  }
  VkBuffer handle() const { return buffer_; }
  const uint8_t* bytes() const { return bytes_; }  // null: there is no such buffer

 private:
  const VulkanDevice& device_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  const uint8_t* bytes_ = nullptr;
};

class VulkanImages : public Images {
 public:
  VulkanImages(std::shared_ptr<const VulkanDevice> device, const Format& format)
      : device_(std::move(device)), format_(format) {}
  ~VulkanImages() override {
    for (const Image& image : images_) {
      device_->DestroyImage(device_->handle, image.handle, nullptr);
      device_->FreeMemory(device_->handle, image.memory, nullptr);
    }
  }

  bool Add(const VkImageCreateInfo& info) {
    Image& image = images_.emplace_back();
    if (device_->CreateImage(device_->handle, &info, nullptr, &image.handle) != VK_SUCCESS) return false;
    VkMemoryRequirements needs{};
    device_->GetImageMemoryRequirements(device_->handle, image.handle, &needs);
    image.memory = device_->Allocate(needs, 0);
    return image.memory != VK_NULL_HANDLE &&
           device_->BindImageMemory(device_->handle, image.handle, image.memory, 0) == VK_SUCCESS;
  }

  bool depth() const override { return format_.depth(); }
  XrStructureType structure() const override { return XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR; }
  size_t structure_size() const override { return sizeof(XrSwapchainImageVulkanKHR); }
  void Describe(uint32_t image, void* structure) const override {
    static_cast<XrSwapchainImageVulkanKHR*>(structure)->image = images_[image].handle;
  }

  bool HandOver(uint32_t index) override {
    Image& image = images_[index];
    if (image.handed_over) return true;
    image.handed_over = device_->Run(
        [&](VkCommandBuffer commands) { Change(commands, image.handle, VK_IMAGE_LAYOUT_UNDEFINED, format_.layout()); });
    return image.handed_over;
  }

  Picture Read(uint32_t index, uint32_t array_index, const XrRect2Di& rect) override {
    const auto width = static_cast<uint32_t>(rect.extent.width);
    const auto height = static_cast<uint32_t>(rect.extent.height);
    if (width == 0 || height == 0) return {};
    const ReadBuffer buffer(*device_, VkDeviceSize{width} * height * kTexelBytes);
    if (buffer.bytes() == nullptr) return {};
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, array_index, 1};
    copy.imageOffset = {rect.offset.x, rect.offset.y, 0};
    copy.imageExtent = {width, height, 1};
    const VkImage image = images_[index].handle;
    const bool done = device_->Run([&](VkCommandBuffer commands) {
      Change(commands, image, format_.layout(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
      device_->CmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.handle(), 1, &copy);
      Change(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, format_.layout());
    });
    return done ? FromTexels(buffer.bytes(), width, height, format_.srgb, format_.blue_first) : Picture{};
  }

 private:
  struct Image {
    VkImage handle = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    bool handed_over = false;
  };

  void Change(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to) const {
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {format_.aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    device_->CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                                nullptr, 0, nullptr, 1, &barrier);
  }

  std::shared_ptr<const VulkanDevice> device_;
  const Format& format_;
  std::vector<Image> images_;
};

class VulkanGraphics : public Graphics {
 public:
  explicit VulkanGraphics(std::shared_ptr<const VulkanDevice> device) : device_(std::move(device)) {
    for (const Format& format : kFormats) {
      VkImageFormatProperties limits{};
      if (Supports(format, format.attachment() | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, 0, &limits))
        formats_.push_back(format.format);
    }
  }

  const std::vector<int64_t>& formats() const override { return formats_; }

  XrResult CreateImages(const XrSwapchainCreateInfo& info, uint32_t count,
                        std::unique_ptr<Images>* images) const override {
    const Format& format = *FindFormat(info.format);
    const VkImageCreateInfo image = ImageInfo(info, format);
    VkImageFormatProperties limits{};
    OMNI_REQUIRE(Supports(format, image.usage, image.flags, &limits), XR_ERROR_FEATURE_UNSUPPORTED);
    OMNI_REQUIRE(info.width <= limits.maxExtent.width && info.height <= limits.maxExtent.height &&
                     info.mipCount <= limits.maxMipLevels && info.arraySize <= limits.maxArrayLayers / info.faceCount,
                 XR_ERROR_VALIDATION_FAILURE);
    auto made = std::make_unique<VulkanImages>(device_, format);
    for (uint32_t i = 0; i < count; ++i) OMNI_REQUIRE(made->Add(image), XR_ERROR_OUT_OF_MEMORY);
    *images = std::move(made);
    return XR_SUCCESS;
  }

 private:
  bool Supports(const Format& format, VkImageUsageFlags usage, VkImageCreateFlags flags,
                VkImageFormatProperties* limits) const {
    return device_->instance.GetPhysicalDeviceImageFormatProperties(device_->physical, format.format, VK_IMAGE_TYPE_2D,
                                                                    VK_IMAGE_TILING_OPTIMAL, usage, flags,
                                                                    limits) == VK_SUCCESS;
  }

  std::shared_ptr<const VulkanDevice> device_;
  std::vector<int64_t> formats_;
};

}  // namespace

XrResult CreateVulkanDeviceGraphics(PFN_vkGetInstanceProcAddr get, const XrGraphicsBindingVulkanKHR& binding,
                                    std::shared_ptr<Graphics>* graphics) {
  const auto device = std::make_shared<VulkanDevice>(get, binding);
  OMNI_REQUIRE(device->Load(binding), XR_ERROR_GRAPHICS_DEVICE_INVALID);
  *graphics = std::make_shared<VulkanGraphics>(device);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
