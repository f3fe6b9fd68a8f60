// XrTime <-> CLOCK_MONOTONIC. The offset is measured outside of xrLocateSpace, which then only adds.
#pragma once

#include <atomic>
#include <cstdint>

#include "layer/src/omni_openxr_compat.h"

namespace omni::layer {

std::int64_t MonotonicNow_ns() noexcept;  // vDSO, no system call

class RuntimeClock {
 public:
  // `convert` may be null: then both clocks are taken as equal until OnFrame shows otherwise.
  RuntimeClock(XrInstance instance, PFN_xrConvertTimespecTimeToTimeKHR convert)
      : instance_(instance), convert_(convert) {}

  // Measures again when the last measurement is older than a second: the runtime's clock may drift from ours.
  void Refresh(std::int64_t now_ns) noexcept;

  // What xrWaitFrame said; used only without XR_KHR_convert_timespec_time.
  void OnFrame(const XrFrameState& frame, std::int64_t now_ns) noexcept;

  XrTime ToXr(std::int64_t monotonic_ns) const noexcept {
    return monotonic_ns + offset_ns_.load(std::memory_order_relaxed);
  }
  std::int64_t ToMonotonic(XrTime time) const noexcept { return time - offset_ns_.load(std::memory_order_relaxed); }

 private:
  XrInstance instance_;
  PFN_xrConvertTimespecTimeToTimeKHR convert_;
  std::atomic<std::int64_t> offset_ns_{0};
  std::atomic<std::int64_t> next_refresh_ns_{0};
};

}  // namespace omni::layer
