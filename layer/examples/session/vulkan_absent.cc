// Built without Vulkan: a session needs XR_MND_headless.
#include "session/session.h"

namespace example {

struct Session::Vulkan {};

const char* Session::VulkanExtension() { return nullptr; }
const void* Session::CreateVulkan(XrSystemId) { return nullptr; }

Session::~Session() {
  if (session_ != XR_NULL_HANDLE) xrDestroySession(session_);
}

}  // namespace example
