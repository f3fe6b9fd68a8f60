// Key states of several keyboards and pedals for the tick, and the decoder of a device's bytes. Accesses no device.
#pragma once

#include <linux/input.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "service/base/input_mapping.h"

namespace omni::daemon {

inline constexpr int kMaxKeyDevicesOpen = 16;  // further ones are not opened

// Counts presses and releases. A key that several devices have is down while one of them holds it.
class KeyBook {
 public:
  // codes[i]: evdev code of slot i; other codes are ignored and leave no trace.
  explicit KeyBook(std::vector<std::uint16_t> codes) : codes_(std::move(codes)) {}

  // `device`: 0 to kMaxKeyDevicesOpen - 1. True: a slot has changed.
  bool Set(int device, std::uint16_t code, bool down, std::int64_t t_ns);
  // The device is gone: releases the keys that it held.
  bool ReleaseAll(int device, std::int64_t t_ns);

  bool IsDown(int device, std::size_t slot) const { return (holders_[slot] >> device & 1) != 0; }
  const std::vector<std::uint16_t>& codes() const { return codes_; }
  const base::KeyStates& states() const { return states_; }

 private:
  bool SetSlot(int device, std::size_t slot, bool down, std::int64_t t_ns);

  const std::vector<std::uint16_t> codes_;
  std::array<std::uint32_t, base::kMaxKeys> holders_{};  // bit: that device holds it
  base::KeyStates states_;
};

// One device's stream of input_event. Whatever the bytes are, it emits only presses and releases, with sane times.
class KeyDecoder {
 public:
  using Emit = std::function<void(std::uint16_t code, bool down, std::int64_t t_ns)>;

  // Events may be cut anywhere between two calls. now_ns: stamps in its future, or over a second before it, are of
  // another clock and count as now.
  void Feed(const unsigned char* bytes, std::size_t count, std::int64_t now_ns, const Emit& emit);

  // The kernel has dropped events since the last call: the keys' states must be queried again.
  bool PopDropped();

 private:
  void Take(const input_event& event, std::int64_t now_ns, const Emit& emit);

  std::array<unsigned char, sizeof(input_event)> partial_{};
  std::size_t partial_bytes_ = 0;
  bool skipping_ = false;  // after SYN_DROPPED, to the end of that report
  bool dropped_ = false;
};

}  // namespace omni::daemon
