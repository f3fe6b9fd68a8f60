#include "service/device/recording/recording_transport.h"

#include <ctime>
#include <utility>

#include "service/base/clock.h"

namespace omni::device {

RecordingTransport::RecordingTransport(std::unique_ptr<Transport> inner, std::unique_ptr<DeviceRecorder> recorder)
    : inner_(std::move(inner)), recorder_(std::move(recorder)) {}

ReadStatus RecordingTransport::Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept {
  const ReadStatus status = inner_->Read(scan, timeout_ns);
  recorder_->SetLastStatus(status);
  if (status == ReadStatus::kScan) recorder_->Add(ScanRecord{.read_ns = base::MonotonicNow_ns(), .scan = scan});
  return status;
}

bool RecordingTransport::Write(const base::CoilCurrents& currents) noexcept {
  const bool sent = inner_->Write(currents);
  recorder_->Add(CommandRecord{.written_ns = base::MonotonicNow_ns(), .currents = currents, .sent = sent ? 1U : 0U});
  return sent;
}

RecordingInfo DescribeForRecording(const TransportInfo& transport, double current_max_A) {
  return {.name = transport.name,
          .serial = transport.serial,
          .simulation = transport.simulation,
          .virtual_time = transport.virtual_time,
          .current_max_A = current_max_A,
          .begun_unix_s = static_cast<std::int64_t>(std::time(nullptr))};
}

}  // namespace omni::device
