// What an OpenGL session needs; a whole one is hello_xr's (tests/layer/hello).

#include <gtest/gtest.h>
// After it: Xlib's header defines words such as None.
#include <GL/glx.h>
#include <X11/Xlib.h>

#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_PLATFORM_XLIB
#include "tests/runtime/cases/graphics/vulkan_fixture.h"

namespace omni::runtime {
namespace {

class OpenglBinding : public VulkanTest {};

TEST_F(OpenglBinding, NeedsItsExtensionItsRequirementsAndAContext) {
  XrSession session = XR_NULL_HANDLE;
  auto binding = Make<XrGraphicsBindingOpenGLXlibKHR>(XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR);
  EXPECT_EQ(CreateSession(&binding, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID) << "it is not enabled";
  PFN_xrVoidFunction none = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrGetOpenGLGraphicsRequirementsKHR", &none),
            XR_ERROR_FUNCTION_UNSUPPORTED);
  DestroyInstance();
  StartVulkan({XR_KHR_OPENGL_ENABLE_EXTENSION_NAME, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME});
  EXPECT_EQ(CreateSession(&binding, &session), XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
  ASSERT_EQ(AskRequirements(), XR_SUCCESS);
  EXPECT_EQ(CreateSession(&binding, &session), XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING) << "those of Vulkan";
  auto needs = Make<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
  const auto ask = Load<PFN_xrGetOpenGLGraphicsRequirementsKHR>("xrGetOpenGLGraphicsRequirementsKHR");
  EXPECT_EQ(ask(instance_, 2, &needs), XR_ERROR_SYSTEM_INVALID);
  ASSERT_EQ(ask(instance_, 1, &needs), XR_SUCCESS);
  EXPECT_LE(needs.minApiVersionSupported, needs.maxApiVersionSupported);
  EXPECT_EQ(CreateSession(&binding, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID) << "there is no context";
  binding.next = &binding_;
  EXPECT_EQ(CreateSession(&binding, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID) << "two bindings";
}

}  // namespace
}  // namespace omni::runtime
