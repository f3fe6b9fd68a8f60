// A transport that passes everything through and records it.
#pragma once

#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/device/recording/device_recorder.h"
#include "service/device/transport.h"

namespace omni::device {

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
