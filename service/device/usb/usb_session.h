// The session with one opened base: HELLO, arming, telemetry in, commands out, counters. Independent of the USB
// library: a UsbLink carries its frames, so tests drive it directly.
//
// Two threads meet here and never wait for each other. The link's thread calls the UsbHandler functions; the caller's
// (the tick) calls Read and Write. The newest scan and the newest command are passed through a base::Latest each.
// FAULT and LOG frames wait in a ring for the thread that logs them (PopNote).
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/wire/messages.h"
#include "service/base/force_limit.h"
#include "service/base/hall_scan.h"
#include "service/base/handover.h"
#include "service/device/base_notes.h"
#include "service/device/clock_map.h"
#include "service/device/commands.h"
#include "service/device/scan_conversion.h"
#include "service/device/transport.h"
#include "service/device/usb/ready_event.h"
#include "service/device/usb/usb_bus.h"

namespace omni::device {

class UsbSession final : public UsbHandler {
 public:
  enum class Hello : std::uint8_t { kMissing, kHere, kGone };

  // Before anything else; `link` outlives every call of Write.
  void Attach(UsbLink& link) noexcept { link_ = &link; }

  // Waits for the base's HELLO; requests it every 100 ms.
  Hello WaitForHello(std::int64_t timeout_ns) noexcept;
  // Once it is kHere.
  const wire::Hello& hello() const noexcept { return hello_; }
  // Why the last refused frame was refused; kOk: none was.
  wire::Status last_refused() const noexcept { return last_refused_.load(std::memory_order_relaxed); }
  // From here on scans are delivered and the base is armed. Before that, telemetry is ignored.
  void Begin(const DeviceInfo& device) noexcept;

  // As Transport's.
  ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept;
  bool Write(const base::CoilCurrents& currents) noexcept;
  TransportCounters counters() const noexcept;
  TransportState state() const noexcept;
  bool PopNote(BaseNote& note) noexcept { return notes_.Pop(note); }

  void OnFrame(const std::uint8_t* data, std::size_t size, std::int64_t t_ns) noexcept override;
  std::size_t NextFrame(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept override;
  void OnSendFailed() noexcept override { ++counters_.send_failed; }
  void OnInterrupted() noexcept override { ++interrupted_; }
  void OnGone() noexcept override;

 private:
  enum class Phase : std::uint8_t { kRequestHello, kHaveHello, kRunning };
  struct ScanSlot {
    base::HallScan scan;
    std::uint64_t index = 0;  // counts the scans passed on; 0: none yet
    std::uint64_t t_device_us = 0;
  };
  struct CommandSlot {
    float set_point_A[wire::kCoils] = {};
    std::uint64_t index = 0;
    std::uint64_t echo_device_us = 0;
    std::int64_t t_ns = 0;  // of Write
  };

  void Refuse(wire::Status status) noexcept;
  void TakeHello(const wire::FrameView& view) noexcept;
  void TakeTelemetry(const wire::FrameView& view, std::int64_t t_ns) noexcept;
  void TakeArm(const wire::FrameView& view, std::int64_t t_ns) noexcept;
  void KeepNote(const wire::FrameView& view) noexcept;
  bool Stamp(const wire::Telemetry& telemetry, std::uint64_t t_device_us, std::int64_t t_ns,
             std::int64_t& scan_t_ns) noexcept;
  bool InOrder(const wire::Header& header) noexcept;
  void Publish(const wire::Telemetry& telemetry, std::uint64_t t_device_us, std::int64_t scan_t_ns) noexcept;
  std::size_t RequestHello(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept;
  bool Repeats(const CommandSlot& slot, std::int64_t t_ns) const noexcept;
  std::size_t NextCommand(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept;

  UsbLink* link_ = nullptr;
  ReadyEvent ready_;
  std::atomic<Phase> phase_{Phase::kRequestHello};
  std::atomic<bool> gone_{false};
  std::atomic<wire::Status> last_refused_{wire::Status::kOk};
  wire::Hello hello_;  // before kHaveHello: the link's thread
  DeviceInfo device_;  // before kRunning: the caller's
  float current_max_A_ = 0;
  base::Latest<ScanSlot> scans_;
  base::Latest<CommandSlot> commands_;
  std::atomic<std::uint32_t> state_and_held_{0};
  std::atomic<std::uint32_t> faults_{0};
  BaseNotes notes_;

  // The link's thread.
  Counters counters_;
  Counter bad_crc_, interrupted_;
  SequenceCounter sequence_;
  Arming arming_;
  ClockMap clock_;
  ResponseTime response_;
  std::int64_t hello_next_ns_ = 0;
  std::uint64_t newest_device_us_ = 0;
  std::uint64_t published_ = 0;
  std::uint64_t commands_taken_ = 0;
  std::int64_t command_sent_ns_ = 0;
  int out_of_order_ = 0;  // frames in a row
  std::uint16_t seq_ = 0;
  bool seq_known_ = false;

  // The caller's thread.
  Counter superseded_, refused_set_points_;
  std::uint64_t scans_read_ = 0;
  std::uint64_t commands_written_ = 0;
  std::uint64_t answered_device_us_ = 0;
};

}  // namespace omni::device
