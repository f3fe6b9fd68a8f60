// Whole frames from one interrupt level to another. One side pushes, one pops; neither ever waits.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "firmware/wire/frame.h"

namespace omni::board {

template <std::uint32_t kDepth>
class FrameRing {
 public:
  // False: full, the frame is lost and counted.
  bool Push(const std::uint8_t* frame, std::size_t size) noexcept {
    const std::uint32_t at = pushed_.load(std::memory_order_relaxed);
    if (at - popped_.load(std::memory_order_acquire) >= kDepth || size > wire::kFrameSizeMax) {
      ++lost_;
      return false;
    }
    Slot& slot = slots_[at % kDepth];
    std::memcpy(slot.bytes, frame, size);
    slot.size = static_cast<std::uint16_t>(size);
    pushed_.store(at + 1, std::memory_order_release);
    return true;
  }

  // 0: empty, or the frame is longer than `capacity` and lost.
  std::size_t Pop(std::uint8_t* frame, std::size_t capacity) noexcept {
    const std::uint32_t at = popped_.load(std::memory_order_relaxed);
    if (at == pushed_.load(std::memory_order_acquire)) return 0;
    const Slot& slot = slots_[at % kDepth];
    const std::size_t size = slot.size <= capacity ? slot.size : 0;
    std::memcpy(frame, slot.bytes, size);
    popped_.store(at + 1, std::memory_order_release);
    return size;
  }

  std::uint32_t lost() const noexcept { return lost_; }

 private:
  static_assert((kDepth & (kDepth - 1)) == 0, "indices wrap");
  struct Slot {
    std::uint16_t size;
    std::uint8_t bytes[wire::kFrameSizeMax];
  };
  Slot slots_[kDepth] = {};
  std::atomic<std::uint32_t> pushed_{0}, popped_{0};
  std::uint32_t lost_ = 0;
};

}  // namespace omni::board
