// Names of the enumerants that our extensions bring: nothing below knows them.
#pragma once

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

// nullptr: not one of ours.
const char* OwnName(XrResult value) noexcept;
const char* OwnName(XrStructureType value) noexcept;

}  // namespace omni::layer
