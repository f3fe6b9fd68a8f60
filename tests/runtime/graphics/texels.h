#pragma once
// Four bytes a texel, as graphics APIs keep them, to linear light.

#include <cstdint>

#include "tests/runtime/graphics/graphics.h"

namespace omni::runtime {

// Rows from the top, without gaps. Not `srgb`: the bytes are linear.
Picture FromTexels(const uint8_t* bytes, uint32_t width, uint32_t height, bool srgb, bool blue_first);

}  // namespace omni::runtime
