#pragma once
// XR_KHR_opengl_enable for X11 (XrGraphicsBindingOpenGLXlibKHR). Built without the headers of GLX, there is none.

#include <openxr/openxr.h>

#include <string_view>

#include "tests/runtime/graphics/graphics.h"

namespace omni::runtime {

std::vector<GraphicsExtension> OpenglExtensions();
PFN_xrVoidFunction FindOpenglFunction(const Instance& instance, std::string_view name);
XrResult CreateOpenglGraphics(const Instance& instance, const void* binding, std::shared_ptr<Graphics>* graphics);

}  // namespace omni::runtime
