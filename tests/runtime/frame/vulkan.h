#pragma once
// XR_KHR_vulkan_enable2, as far as an application needs it to get a session: instance and device are made with the
// application's own loader, and nothing is ever drawn. Built without Vulkan's headers, it is not available.

#include <openxr/openxr.h>

#include <string_view>

#include "tests/runtime/objects.h"

namespace omni::runtime {

// Null: built without.
const char* VulkanExtension();

// Of an instance that enabled it; null: not one of its functions.
PFN_xrVoidFunction FindVulkanFunction(std::string_view name);

// The chain of XrSessionCreateInfo of such an instance.
XrResult CheckVulkanBinding(const Instance& instance, const void* chain);

}  // namespace omni::runtime
