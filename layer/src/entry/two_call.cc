#include "layer/src/entry/two_call.h"

namespace omni::layer {

XrResult CheckCapacity(std::size_t n, std::uint32_t capacity, std::uint32_t* count, const void* out) {
  if (!count) return XR_ERROR_VALIDATION_FAILURE;
  *count = static_cast<std::uint32_t>(n);
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < n) return XR_ERROR_SIZE_INSUFFICIENT;
  return out ? XR_SUCCESS : XR_ERROR_VALIDATION_FAILURE;
}

}  // namespace omni::layer
