// Histogram of durations, 8 buckets per octave (12 % resolution): one writer, any number of readers, no lock.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

namespace omni::loop {

class Histogram {
 public:
  // One writer thread. Negative durations count as 0.
  void Add(std::int64_t duration_ns) noexcept {
    const std::uint64_t value = duration_ns > 0 ? static_cast<std::uint64_t>(duration_ns) : 0;
    std::atomic<std::uint64_t>& bucket = buckets_[IndexOf(value)];
    bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (value > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(value, std::memory_order_relaxed);
  }

  std::uint64_t count() const noexcept {
    std::uint64_t sum = 0;
    for (const auto& bucket : buckets_) sum += bucket.load(std::memory_order_relaxed);
    return sum;
  }

  // Upper edge of the bucket that holds the q-quantile (q in [0, 1]), at most the maximum, in microseconds; 0 when
  // empty.
  double Quantile_us(double q) const noexcept {
    const double wanted = q * static_cast<double>(count());
    double seen = 0;
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      const auto n = static_cast<double>(buckets_[i].load(std::memory_order_relaxed));
      seen += n;
      if (n > 0 && seen >= wanted) return std::min(static_cast<double>(UpperEdge(i)) * 1e-3, max_us());
    }
    return 0;
  }

  double max_us() const noexcept { return static_cast<double>(max_ns_.load(std::memory_order_relaxed)) * 1e-3; }

 private:
  static constexpr std::size_t kSub = 8;

  // Values below 8 have their own bucket; above, the octave and the next three bits.
  static std::size_t IndexOf(std::uint64_t value) noexcept {
    if (value < kSub) return static_cast<std::size_t>(value);
    const auto octave = static_cast<std::size_t>(std::bit_width(value)) - 4;  // 0 for 8..15
    return kSub * (octave + 1) + static_cast<std::size_t>((value >> octave) - kSub);
  }
  static std::uint64_t UpperEdge(std::size_t index) noexcept {
    if (index < kSub) return index;
    const std::size_t octave = index / kSub - 1;
    return ((index % kSub + kSub + 1) << octave) - 1;
  }

  std::array<std::atomic<std::uint64_t>, 62 * kSub> buckets_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace omni::loop
