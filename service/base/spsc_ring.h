// Fixed ring from one producer thread to one consumer thread. When full, TryPush fails and the producer counts the
// loss.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace omni::base {

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
