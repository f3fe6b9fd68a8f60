// Counters of a transport: written by the thread that reads and writes frames, read by any.
#pragma once

#include <atomic>
#include <cstdint>

#include "service/device/transport.h"

namespace omni::device {

// One writer. Every count is exact by itself; two of one snapshot may be a frame apart.
class Counter {
 public:
  void Set(std::uint64_t value) noexcept { value_.store(value, std::memory_order_relaxed); }
  void operator++() noexcept { Set(value() + 1); }
  std::uint64_t value() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

struct Counters {
  Counter received, missed, superseded, bad_frames, sent, send_failed;

  TransportCounters Snapshot() const noexcept {
    return {.received = received.value(),
            .missed = missed.value(),
            .superseded = superseded.value(),
            .bad_frames = bad_frames.value(),
            .sent = sent.value(),
            .send_failed = send_failed.value()};
  }
};

}  // namespace omni::device
