// USB1: PHY, controller, and frames between the control step and the host. The driver runs in the USB interrupt alone;
// the control step, which may interrupt it, only fills and empties rings and triggers that interrupt.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "firmware/board/teensy40/chip/registers.h"
#include "firmware/core/link/settings.h"
#include "firmware/drivers/usb_device.h"
#include "firmware/wire/frame.h"

namespace omni::board {

// Whole frames from one interrupt level to another. One side pushes, one pops; neither ever waits.
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

class UsbPort {
 public:
  explicit UsbPort(const firmware::Settings& settings) noexcept;

  // Clocks run already. Takes 25 ms if the boot loader has used the controller: the host must see the device leave.
  void Start() noexcept;
  void HandleInterrupt() noexcept;

  // Control step.
  std::size_t Receive(std::uint8_t* frame, std::size_t capacity) noexcept { return from_host_.Pop(frame, capacity); }
  bool Send(const std::uint8_t* frame, std::size_t size) noexcept {
    const bool taken = to_host_.Push(frame, size);
    nvic::Pend(Irq::kUsb1);
    return taken;
  }
  // The host has requested an emergency stop through endpoint 0: true for kEmergencyStopHold calls, one per control
  // step, longer than the core's hold time.
  bool EmergencyStop() noexcept;

 private:
  static constexpr int kEmergencyStopHold = 40;  // 10 ms

  // firmware/drivers/usb_device.h. On-chip RAM is not cached here; barriers keep the order of accesses.
  struct Bus {
    std::uint32_t Read(std::uint32_t offset) noexcept { return RegisterAt(kUsb1Base + offset); }
    void Write(std::uint32_t offset, std::uint32_t value) noexcept {
      DataBarrier();
      RegisterAt(kUsb1Base + offset) = value;
    }
    std::uint32_t Address(const volatile void* memory) noexcept {
      return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(memory));
    }
    void CleanCache(const volatile void*, std::size_t) noexcept { DataBarrier(); }
    void InvalidateCache(const volatile void*, std::size_t) noexcept { DataBarrier(); }
  };
  struct Handler {
    const firmware::Settings& settings;
    std::atomic<bool> emergency_stop{false};
    void EmergencyStop() noexcept { emergency_stop.store(true); }
    std::size_t WriteHello(std::uint8_t* frame, std::size_t capacity) noexcept;
  };

  Bus bus_;
  Handler handler_;
  drivers::usb::UsbDevice<Bus, Handler> device_;
  FrameRing<8> from_host_;
  FrameRing<16> to_host_;
  int stop_held_ = 0;
};

}  // namespace omni::board
