#pragma once
// The parts of swapchain images that a layer shows.

#include "tests/runtime/state.h"

namespace omni::runtime {

// Swapchains of this session that have released an image, parts that lie within it, arrays, faces and depths as the
// layer's type needs them. A headless session has no swapchains: what its layers say of images is not looked at.
// Precondition: the layer's type is one that this runtime knows, and a projection has its views.
XrResult CheckSubImages(const Session& session, const XrCompositionLayerBaseHeader& layer);

}  // namespace omni::runtime
