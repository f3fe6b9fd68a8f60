#pragma once
// What a graphics API has to do for this runtime: images that the application can draw into, and their texels.

#include <openxr/openxr.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace omni::runtime {

struct Instance;

// Linear light, four floats a texel (red, green, blue, alpha), rows from the top.
struct Picture {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<float> rgba;
};

// The images of one swapchain, destroyed with it.
class Images {
 public:
  virtual ~Images() = default;
  virtual bool depth() const = 0;
  // The structure that the application passes to xrEnumerateSwapchainImages.
  virtual XrStructureType structure() const = 0;
  virtual size_t structure_size() const = 0;
  virtual void Describe(uint32_t image, void* structure) const = 0;
  // Before the application draws into it: the layout that the specification promises. False: the API failed.
  virtual bool HandOver(uint32_t image) = 0;
  // A released colour image; `rect` as the API counts its rows. Empty: the API failed.
  virtual Picture Read(uint32_t image, uint32_t array_index, const XrRect2Di& rect) = 0;
};

// The graphics of one session.
class Graphics {
 public:
  virtual ~Graphics() = default;
  // The API's numbers, the best first.
  virtual const std::vector<int64_t>& formats() const = 0;
  // The caller has checked what the API has no say in; limits and usages are checked here.
  virtual XrResult CreateImages(const XrSwapchainCreateInfo& info, uint32_t count,
                                std::unique_ptr<Images>* images) const = 0;
};

struct GraphicsExtension {
  const char* name;
  uint32_t version;
};
// Of the APIs that this runtime was built with.
std::vector<GraphicsExtension> GraphicsExtensions();

// Functions of the extensions that the instance enabled; null: not one of them.
PFN_xrVoidFunction FindGraphicsFunction(const Instance& instance, const char* name);

// From the chain of XrSessionCreateInfo, which must have exactly one binding; none is allowed with XR_MND_headless, and
// gives no graphics.
XrResult CreateGraphics(const Instance& instance, const void* chain, std::shared_ptr<Graphics>* graphics);

}  // namespace omni::runtime
