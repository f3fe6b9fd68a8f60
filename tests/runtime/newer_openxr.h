#pragma once
// What Debian's OpenXR 1.0.20 headers lack and this runtime has: values of the registry, which the layer needs as well.

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::runtime {

// OpenXR 1.1
inline constexpr auto kStereoWithFoveatedInset = static_cast<XrViewConfigurationType>(1000037000);
inline constexpr auto kLocalFloor = static_cast<XrReferenceSpaceType>(kReferenceSpaceTypeLocalFloor);

}  // namespace omni::runtime
