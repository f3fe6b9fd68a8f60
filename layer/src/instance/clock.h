// XrTime <-> CLOCK_MONOTONIC. The offset is measured outside of xrLocateSpace, which then only adds.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

// The offset of a runtime's clock, from its xrWaitFrame alone.
//
// A frame says when it will be displayed. We assume 1.5 periods after xrWaitFrame returned, which may be off by a
// period either way; there is no better estimate. Late returns and frames planned for later are outliers, hence the
// median of the last frames. It follows a clock that drifts by 100 ppm within 20 us at 90 Hz.
class FrameClock {
 public:
  static constexpr std::size_t kFrames = 31;

  // Adds one frame; `now_ns`: when xrWaitFrame returned. Returns the offset, XrTime - CLOCK_MONOTONIC.
  std::int64_t Add(const XrFrameState& frame, std::int64_t now_ns) noexcept;

 private:
  std::array<std::int64_t, kFrames> offsets_ns_{};
  std::size_t frames_ = 0;  // ever
};

class RuntimeClock {
 public:
  // `convert` may be null: then both clocks are taken as equal until OnFrame shows otherwise.
  RuntimeClock(XrInstance instance, PFN_xrConvertTimespecTimeToTimeKHR convert)
      : instance_(instance), convert_(convert) {}

  // Measures again when the last measurement is older than a second: the runtime's clock may drift from ours.
  void Refresh(std::int64_t now_ns) noexcept;

  // What xrWaitFrame said; used only without XR_KHR_convert_timespec_time. From any thread.
  void OnFrame(const XrFrameState& frame, std::int64_t now_ns) noexcept;

  XrTime ToXr(std::int64_t monotonic_ns) const noexcept {
    return monotonic_ns + offset_ns_.load(std::memory_order_relaxed);
  }
  // Any XrTime; clamped to the range of our own times.
  std::int64_t ToMonotonic(XrTime time) const noexcept;

 private:
  XrInstance instance_;
  PFN_xrConvertTimespecTimeToTimeKHR convert_;
  std::atomic<std::int64_t> offset_ns_{0};
  std::atomic<std::int64_t> next_refresh_ns_{0};
  std::mutex frames_mutex_;
  FrameClock frames_;
};

}  // namespace omni::layer
