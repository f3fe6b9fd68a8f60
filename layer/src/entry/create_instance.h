// The layer's part of instance creation.
#pragma once

#include "layer/src/entry/loader_interface.h"

namespace omni::layer {

inline constexpr const char* kLayerName = "XR_APILAYER_OMNI_stylus";

XrResult CreateApiLayerInstance(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo* layer_info,
                                XrInstance* instance);

// Answers of this layer alone.
XrResult EnumerateLayers(uint32_t capacity, uint32_t* count, XrApiLayerProperties* properties);
XrResult EnumerateExtensions(const char* layer_name, uint32_t capacity, uint32_t* count,
                             XrExtensionProperties* properties);

}  // namespace omni::layer
