// Values from one thread to another; neither ever waits.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace omni::base {

// Hands the newest value from one writer thread to one reader thread.
// A triple buffer: the writer owns one slot, the reader one, the third is exchanged atomically.
template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  // Writer thread only.
  void Write(const T& value) noexcept {
    WriteWith([&value](T& slot) { slot = value; });
  }

  // The same without a copy of its own: `fill(T&)` is given the slot, with some older value in it.
  template <class Fill>
  void WriteWith(Fill&& fill) noexcept {
    fill(slots_[writer_]);
    const std::uint8_t previous =
        exchange_.exchange(static_cast<std::uint8_t>(writer_ | kFresh), std::memory_order_acq_rel);
    writer_ = previous & kIndex;
  }

  // Reader thread only. The reference stays valid and unchanged until the next Read().
  const T& Read() noexcept {
    if (exchange_.load(std::memory_order_relaxed) & kFresh) {
      const std::uint8_t previous = exchange_.exchange(reader_, std::memory_order_acq_rel);
      reader_ = previous & kIndex;
    }
    return slots_[reader_];
  }

 private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kIndex = 3;
  std::array<T, 3> slots_{};
  std::uint8_t writer_ = 0;
  std::uint8_t reader_ = 1;
  std::atomic<std::uint8_t> exchange_{2};
};

// Fixed ring from one producer thread to one consumer thread. When full, TryPush fails and the producer counts the
// loss.
template <class T, std::size_t kCapacity>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T>);
  static_assert((kCapacity & (kCapacity - 1)) == 0, "capacity is a power of two");

 public:
  // Producer only. False: full, nothing written.
  bool TryPush(const T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == kCapacity) return false;
    slots_[head & (kCapacity - 1)] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  // Consumer only. False: empty.
  bool TryPop(T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return false;
    value = slots_[tail & (kCapacity - 1)];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, kCapacity> slots_;  // no {}: compilers unroll it
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace omni::base
