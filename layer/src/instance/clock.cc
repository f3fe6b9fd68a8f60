#include "layer/src/instance/clock.h"

#include <algorithm>

namespace omni::layer {
namespace {
constexpr std::int64_t kRefreshInterval_ns = 1'000'000'000;
// Far beyond any uptime, and differences of two such times still fit.
constexpr std::int64_t kLongest_ns = std::int64_t{1} << 61;
}  // namespace

std::int64_t FrameClock::Add(const XrFrameState& frame, std::int64_t now_ns) noexcept {
  const std::int64_t period_ns = std::clamp<std::int64_t>(frame.predictedDisplayPeriod, 0, 1'000'000'000);
  const std::int64_t seen_ns = std::clamp(frame.predictedDisplayTime, -kLongest_ns, kLongest_ns);
  offsets_ns_[frames_++ % kFrames] = seen_ns - period_ns * 3 / 2 - now_ns;
  std::array<std::int64_t, kFrames> sorted = offsets_ns_;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(std::min(frames_, kFrames));
  const auto median = sorted.begin() + (end - sorted.begin()) / 2;
  std::nth_element(sorted.begin(), median, end);
  // A frame shown up to 4 periods after xrWaitFrame: both clocks are the same, and nothing has to be guessed.
  const bool same_clock = *median >= -period_ns * 3 / 2 && *median <= period_ns * 5 / 2;
  return same_clock ? 0 : *median;
}

void RuntimeClock::Refresh(std::int64_t now_ns) noexcept {
  if (!convert_ || now_ns < next_refresh_ns_.load(std::memory_order_relaxed)) return;
  const timespec now{static_cast<time_t>(now_ns / 1'000'000'000), static_cast<long>(now_ns % 1'000'000'000)};
  XrTime time = 0;
  if (XR_FAILED(convert_(instance_, &now, &time))) return;
  offset_ns_.store(std::clamp(time, -kLongest_ns, kLongest_ns) - now_ns, std::memory_order_relaxed);
  next_refresh_ns_.store(now_ns + kRefreshInterval_ns, std::memory_order_relaxed);
}

void RuntimeClock::OnFrame(const XrFrameState& frame, std::int64_t now_ns) noexcept {
  if (convert_) return;
  const std::lock_guard lock(frames_mutex_);
  offset_ns_.store(frames_.Add(frame, now_ns), std::memory_order_relaxed);
}

std::int64_t RuntimeClock::ToMonotonic(XrTime time) const noexcept {
  return std::clamp(time, -kLongest_ns, kLongest_ns) - offset_ns_.load(std::memory_order_relaxed);
}

}  // namespace omni::layer
