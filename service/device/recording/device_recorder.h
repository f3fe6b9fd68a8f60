// Writes a device recording (recording_format.h) from a thread of its own. The caller passes scans and commands
// through a ring and never waits; records that find the ring full are lost and counted.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "service/base/handover.h"
#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/device/recording/recording_format.h"
#include "service/device/transport.h"

namespace omni::device {

class DeviceRecorder {
 public:
  // Creates or truncates `path` and writes the header.
  static base::Result<std::unique_ptr<DeviceRecorder>> Open(const std::string& path, const RecordingInfo& info);
  ~DeviceRecorder();  // closes
  DeviceRecorder(const DeviceRecorder&) = delete;
  DeviceRecorder& operator=(const DeviceRecorder&) = delete;

  // One thread at a time, that of the transport. No system call, no lock, no allocation.
  void Add(const ScanRecord& record) noexcept;
  void Add(const CommandRecord& record) noexcept;
  // After the last Add: writes what is queued and the end record. written() and problem() are final then.
  void Close();
  void SetLastStatus(ReadStatus status) noexcept { last_status_.store(status, std::memory_order_relaxed); }

  // Any thread.
  std::uint64_t lost() const noexcept { return lost_.value(); }        // found the ring full
  std::uint64_t written() const noexcept { return written_.value(); }  // scans and commands in the file
  // Empty, or why a record could not be written (disk full); nothing is written after that.
  std::string problem() const;
  const std::string& path() const noexcept { return path_; }

 private:
  static constexpr std::size_t kRingSize = 4096;  // about two seconds

  struct Entry {
    RecordKind kind;
    std::uint32_t sent;
    std::int64_t t_ns;
    base::HallScan scan;  // of a command: coil_current_A are its set-points
  };
  using Ring = base::SpscRing<Entry, kRingSize>;

  DeviceRecorder(base::UniqueFd file, std::string path);
  void Push(const Entry& entry) noexcept;
  void Run();
  void Drain();
  void Write();
  template <class Record>
  void Append(const Record& record);

  base::UniqueFd file_;
  const std::string path_;
  std::unique_ptr<Ring> ring_;
  Counter lost_;
  Counter written_;
  std::atomic<ReadStatus> last_status_{ReadStatus::kScan};
  std::atomic<int> error_{0};  // errno of the write that failed
  std::atomic<bool> stop_{false};
  // Writer thread only.
  std::vector<std::uint8_t> bytes_;
  std::uint64_t scans_ = 0;
  std::uint64_t commands_ = 0;
  std::uint64_t lost_reported_ = 0;
  std::thread thread_;
};

// A transport that passes everything through and records it.
class RecordingTransport final : public Transport {
 public:
  RecordingTransport(std::unique_ptr<Transport> inner, std::unique_ptr<DeviceRecorder> recorder);

  ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept override;
  bool Write(const base::CoilCurrents& currents) noexcept override;
  const TransportInfo& info() const noexcept override { return inner_->info(); }
  TransportCounters counters() const noexcept override { return inner_->counters(); }
  TransportState state() const noexcept override { return inner_->state(); }
  bool PopNote(BaseNote& note) noexcept override { return inner_->PopNote(note); }
  // Call its Close() after the last Read and Write.
  DeviceRecorder& recorder() noexcept { return *recorder_; }

 private:
  std::unique_ptr<Transport> inner_;
  std::unique_ptr<DeviceRecorder> recorder_;
};

// The recording's description of `transport`. current_max_A: largest set-point that it accepts.
RecordingInfo DescribeForRecording(const TransportInfo& transport, double current_max_A);

}  // namespace omni::device
