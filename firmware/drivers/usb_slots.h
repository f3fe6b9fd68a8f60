// A queue of packet buffers: `order` lists the slots, the first `count` of them hold transfers (oldest first), the
// one after is filled next.
#pragma once

#include <cstddef>
#include <cstdint>

namespace omni::drivers::usb {

template <int kDepth>
class SlotQueue {
 public:
  SlotQueue() noexcept { Clear(); }

  void Clear() noexcept {
    for (int i = 0; i < kDepth; ++i) order_[i] = static_cast<std::uint8_t>(i);
    count_ = 0;
  }

  int count() const noexcept { return count_; }
  bool full() const noexcept { return count_ == kDepth; }
  int front() const noexcept { return order_[0]; }
  // Only while not full. Removing an older one does not change which slot this is.
  int next() const noexcept { return order_[count_]; }
  std::size_t size(int slot) const noexcept { return size_[slot]; }

  void Push(std::size_t size) noexcept {
    size_[next()] = static_cast<std::uint16_t>(size);
    ++count_;
  }

  // 0: the oldest.
  void Remove(int position) noexcept {
    const std::uint8_t slot = order_[position];
    for (int i = position; i + 1 < kDepth; ++i) order_[i] = order_[i + 1];
    order_[kDepth - 1] = slot;
    --count_;
  }

 private:
  std::uint8_t order_[kDepth] = {};
  std::uint16_t size_[kDepth] = {};
  int count_ = 0;
};

}  // namespace omni::drivers::usb
