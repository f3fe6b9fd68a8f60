// Entry points of XR_FB_haptic_pcm.
#pragma once

#include <vector>

#include "layer/src/dispatch.h"

namespace omni::layer {

XRAPI_ATTR XrResult XRAPI_CALL GetDeviceSampleRateFB(XrSession session, const XrHapticActionInfo* info,
                                                     XrDevicePcmSampleRateGetInfoFB* rate);

// For runtimes that have no such function.
const std::vector<OwnFunction>& HapticFunctions();

}  // namespace omni::layer
