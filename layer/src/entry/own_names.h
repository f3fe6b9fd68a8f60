// Names of the enumerants of our extensions, which the runtime does not know.
#pragma once

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

// nullptr: not one of ours.
const char* OwnName(XrResult value) noexcept;
const char* OwnName(XrStructureType value) noexcept;

}  // namespace omni::layer
