#include "tests/runtime/graphics/opengl.h"

namespace omni::runtime {

std::vector<GraphicsExtension> OpenglExtensions() { return {}; }
PFN_xrVoidFunction FindOpenglFunction(const Instance&, std::string_view) { return nullptr; }
XrResult CreateOpenglGraphics(const Instance&, const void*, std::shared_ptr<Graphics>*) {
  return XR_ERROR_GRAPHICS_DEVICE_INVALID;
}

}  // namespace omni::runtime
