#include "layer/src/haptic_functions.h"

#include "layer/src/guarded.h"

namespace omni::layer {

XRAPI_ATTR XrResult XRAPI_CALL GetDeviceSampleRateFB(XrSession session, const XrHapticActionInfo* info,
                                                     XrDevicePcmSampleRateGetInfoFB* rate) {
  return On(session, &Instance::DeviceSampleRate, session, info, rate);
}

const std::vector<OwnFunction>& HapticFunctions() {
  static const std::vector<OwnFunction> functions{
      {"xrGetDeviceSampleRateFB", XR_FB_HAPTIC_PCM_EXTENSION_NAME, Erase(&GetDeviceSampleRateFB)}};
  return functions;
}

}  // namespace omni::layer
