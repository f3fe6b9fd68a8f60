#include "tests/runtime/graphics/graphics.h"

#include <openxr/openxr_platform.h>

#include "tests/runtime/graphics/opengl.h"
#include "tests/runtime/graphics/vulkan.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

struct Api {
  std::vector<GraphicsExtension> (*extensions)();
  PFN_xrVoidFunction (*find)(const Instance& instance, std::string_view name);
  XrStructureType binding;
  XrResult (*create)(const Instance& instance, const void* binding, std::shared_ptr<Graphics>* graphics);
};

constexpr Api kApis[] = {
    {&VulkanExtensions, &FindVulkanFunction, XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR, &CreateVulkanGraphics},
    {&OpenglExtensions, &FindOpenglFunction, XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR, &CreateOpenglGraphics},
};

constexpr XrStructureType kBindings[] = {
    XR_TYPE_GRAPHICS_BINDING_OPENGL_WIN32_KHR,
    XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR,
    XR_TYPE_GRAPHICS_BINDING_OPENGL_XCB_KHR,
    XR_TYPE_GRAPHICS_BINDING_OPENGL_WAYLAND_KHR,
    XR_TYPE_GRAPHICS_BINDING_OPENGL_ES_ANDROID_KHR,
    XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR,
    XR_TYPE_GRAPHICS_BINDING_D3D11_KHR,
    XR_TYPE_GRAPHICS_BINDING_D3D12_KHR,
    XR_TYPE_GRAPHICS_BINDING_EGL_MNDX,
};

bool IsBinding(XrStructureType type) {
  return std::find(std::begin(kBindings), std::end(kBindings), type) != std::end(kBindings);
}

}  // namespace

std::vector<GraphicsExtension> GraphicsExtensions() {
  std::vector<GraphicsExtension> all;
  for (const Api& api : kApis) {
    const std::vector<GraphicsExtension> some = api.extensions();
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

PFN_xrVoidFunction FindGraphicsFunction(const Instance& instance, const char* name) {
  for (const Api& api : kApis) {
    if (const PFN_xrVoidFunction found = api.find(instance, name)) return found;
  }
  return nullptr;
}

XrResult CreateGraphics(const Instance& instance, const void* chain, std::shared_ptr<Graphics>* graphics) {
  const XrBaseInStructure* binding = nullptr;
  for (const auto* link = static_cast<const XrBaseInStructure*>(chain); link != nullptr; link = link->next) {
    if (!IsBinding(link->type)) continue;
    OMNI_REQUIRE(binding == nullptr, XR_ERROR_GRAPHICS_DEVICE_INVALID);
    binding = link;
  }
  if (binding == nullptr) return instance.headless ? XR_SUCCESS : XR_ERROR_GRAPHICS_DEVICE_INVALID;
  for (const Api& api : kApis) {
    if (binding->type == api.binding) return api.create(instance, binding, graphics);
  }
  return XR_ERROR_GRAPHICS_DEVICE_INVALID;
}

}  // namespace omni::runtime
