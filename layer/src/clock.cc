#include "layer/src/clock.h"

#include <cstdlib>

namespace omni::layer {
namespace {
constexpr std::int64_t kRefreshInterval_ns = 1'000'000'000;
// A predicted display time within this of our clock means that both are the same clock.
constexpr std::int64_t kSameClock_ns = 200'000'000;
}  // namespace

std::int64_t MonotonicNow_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void RuntimeClock::Refresh(std::int64_t now_ns) noexcept {
  if (!convert_ || now_ns < next_refresh_ns_.load(std::memory_order_relaxed)) return;
  const timespec now{static_cast<time_t>(now_ns / 1'000'000'000), static_cast<long>(now_ns % 1'000'000'000)};
  XrTime time = 0;
  if (XR_FAILED(convert_(instance_, &now, &time))) return;
  offset_ns_.store(time - now_ns, std::memory_order_relaxed);
  next_refresh_ns_.store(now_ns + kRefreshInterval_ns, std::memory_order_relaxed);
}

void RuntimeClock::OnFrame(const XrFrameState& frame, std::int64_t now_ns) noexcept {
  if (convert_) return;
  // xrWaitFrame returns when a frame starts; its light is seen one to two periods later.
  const std::int64_t frame_now = frame.predictedDisplayTime - frame.predictedDisplayPeriod * 3 / 2;
  const std::int64_t offset = frame_now - now_ns;
  offset_ns_.store(std::llabs(offset) < kSameClock_ns ? 0 : offset, std::memory_order_relaxed);
}

}  // namespace omni::layer
