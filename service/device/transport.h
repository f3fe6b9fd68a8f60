// Transport: carries scans from a base and currents to it. Two calls; the twin, a real device and a recording implement
// it, and one contract test suite covers every implementation.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "service/base/force_limit.h"
#include "service/base/hall_scan.h"
#include "service/device/base_notes.h"

namespace omni::device {

enum class ReadStatus : std::uint8_t {
  kScan = 0,     // `scan` is filled
  kTimeout = 1,  // nothing arrived in time
  kGone = 2,     // the device is gone; the daemon decides whether to open it again
  kEnd = 3       // a recording or a virtual run is over
};

struct TransportInfo {
  std::string name;  // shown to users: "twin", "usb 1209:0001", "replay FILE"
  std::string serial;
  bool simulation = false;    // every figure measured with it is marked as simulated
  double field_range_T = 0;   // of its sensors, as it reports; 0: it does not
  bool virtual_time = false;  // Read never waits: time comes from the scans
};

struct TransportCounters {
  std::uint64_t received = 0;
  std::uint64_t missed = 0;      // gaps in the device's sequence
  std::uint64_t superseded = 0;  // received, but a newer scan was already waiting
  std::uint64_t bad_frames = 0;  // CRC, size, magic, version, order or content
  std::uint64_t bad_crc = 0;     // those of them that failed the CRC
  std::uint64_t sent = 0;
  std::uint64_t send_failed = 0;
  std::uint64_t interrupted = 0;  // system calls and transfers that were restarted
};

// The base's state, by its last telemetry.
struct TransportState {
  std::uint8_t state = 0;         // wire::State
  bool waits_for_person = false;  // not rearmed automatically: a fault occurred that is not the host's
  std::uint32_t faults = 0;       // wire::Fault
};

class Transport {
 public:
  virtual ~Transport() = default;
  // Waits at most timeout_ns for the next scan. No allocation.
  virtual ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept = 0;
  // Sends set-points with their time to live; never waits. Non-finite values are refused (false, nothing sent).
  virtual bool Write(const base::CoilCurrents& currents) noexcept = 0;
  virtual const TransportInfo& info() const noexcept = 0;
  // Any thread, while another reads and writes.
  virtual TransportCounters counters() const noexcept = 0;
  // Any thread. All zero where a transport does not know.
  virtual TransportState state() const noexcept { return {}; }
  // The next FAULT or LOG of the base; false: none. One thread, which may be another one than Read's.
  virtual bool PopNote(BaseNote& /*note*/) noexcept { return false; }
};

// Counts of a transport: one writer, the thread that reads and writes frames; read by any. Every count is exact by
// itself; two of one snapshot may be a frame apart.
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
