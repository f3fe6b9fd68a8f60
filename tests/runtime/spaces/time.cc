// XR_KHR_convert_timespec_time.

#include <shared_mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/state.h"

namespace omni::runtime {

XrResult ConvertTimespecTimeToTimeKHR(XrInstance instance, const timespec* from, XrTime* time) {
  const std::shared_lock lock(TheState().mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(from != nullptr && time != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const bool in_range = from->tv_sec >= 0 && from->tv_sec < INT64_MAX / (2 * kSecond_ns) && from->tv_nsec >= 0 &&
                        from->tv_nsec < kSecond_ns;
  OMNI_REQUIRE(in_range, XR_ERROR_TIME_INVALID);
  *time = int64_t{from->tv_sec} * kSecond_ns + from->tv_nsec + kTimeOffset_ns;
  return XR_SUCCESS;
}

// Times before the machine's boot have no timespec.
XrResult ConvertTimeToTimespecTimeKHR(XrInstance instance, XrTime time, timespec* to) {
  const std::shared_lock lock(TheState().mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(to != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(time > kTimeOffset_ns, XR_ERROR_TIME_INVALID);
  const int64_t monotonic_ns = time - kTimeOffset_ns;
  *to = {monotonic_ns / kSecond_ns, monotonic_ns % kSecond_ns};
  return XR_SUCCESS;
}

}  // namespace omni::runtime
