#include "service/device/recording/device_recorder.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <utility>

#include "service/base/clock.h"
#include "service/base/files/whole_file.h"

namespace omni::device {
namespace {

constexpr std::chrono::milliseconds kNap{20};
constexpr std::size_t kWriteSize = 1U << 18;  // bytes handed to the kernel at once

// 0, or the errno of the failure.
int WriteAll(int fd, const std::uint8_t* bytes, std::size_t size) noexcept {
  for (std::size_t done = 0; done < size;) {
    const ssize_t written = write(fd, bytes + done, size - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written < 0 ? errno : EIO;
    done += static_cast<std::size_t>(written);
  }
  return 0;
}

}  // namespace

base::Result<std::unique_ptr<DeviceRecorder>> DeviceRecorder::Open(const std::string& path, const RecordingInfo& info) {
  base::Result<base::UniqueFd> file = base::MakeNewFile(path);
  if (!file.ok()) return base::Error{file.error()};
  std::array<std::uint8_t, kRecordingHeaderSize> header;
  EncodeHeader(info, header.data());
  if (const int error = WriteAll(file->get(), header.data(), header.size()); error != 0) {
    return base::Error{path + ": the recording cannot be written: " + std::strerror(error) +
                       ": choose a folder that exists, is writable and has room"};
  }
  return std::unique_ptr<DeviceRecorder>(new DeviceRecorder(std::move(*file), path));
}

DeviceRecorder::DeviceRecorder(base::UniqueFd file, std::string path)
    : file_(std::move(file)), path_(std::move(path)), ring_(std::make_unique<Ring>()) {
  bytes_.reserve(kWriteSize + kRecordSizeMax);
  thread_ = std::thread([this] { Run(); });
}

DeviceRecorder::~DeviceRecorder() { Close(); }

void DeviceRecorder::Close() {
  stop_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void DeviceRecorder::Add(const ScanRecord& record) noexcept {
  Push({.kind = RecordKind::kScan, .sent = 0, .t_ns = record.read_ns, .scan = record.scan});
}

void DeviceRecorder::Add(const CommandRecord& record) noexcept {
  Entry entry{.kind = RecordKind::kCommand, .sent = record.sent, .t_ns = record.written_ns, .scan = {}};
  entry.scan.coil_current_A = record.currents.current_A;
  Push(entry);
}

void DeviceRecorder::Push(const Entry& entry) noexcept {
  if (!ring_->TryPush(entry)) ++lost_;
}

std::string DeviceRecorder::problem() const {
  const int error = error_.load(std::memory_order_acquire);
  if (error == 0) return "";
  return path_ + ": the recording ends here: " + std::strerror(error) + ": free some space and record again";
}

void DeviceRecorder::Run() {
  while (!stop_.load(std::memory_order_acquire)) {
    Drain();
    std::this_thread::sleep_for(kNap);
  }
  Drain();
  Append(EndRecord{.scans = scans_,
                   .commands = commands_,
                   .lost = lost_.value(),
                   .last_status = static_cast<std::uint32_t>(last_status_.load(std::memory_order_relaxed))});
  Write();
}

void DeviceRecorder::Drain() {
  Entry entry;
  while (ring_->TryPop(entry)) {
    if (entry.kind == RecordKind::kScan) {
      Append(ScanRecord{.read_ns = entry.t_ns, .scan = entry.scan});
      ++scans_;
    } else {
      Append(CommandRecord{.written_ns = entry.t_ns, .currents = {entry.scan.coil_current_A}, .sent = entry.sent});
      ++commands_;
    }
    if (bytes_.size() >= kWriteSize) Write();
  }
  if (const std::uint64_t lost = lost_.value(); lost != lost_reported_) {
    Append(LossRecord{.lost = lost});
    lost_reported_ = lost;
  }
  Write();
}

// After a failure the ring is still emptied.
void DeviceRecorder::Write() {
  int error = error_.load(std::memory_order_relaxed);
  if (error == 0) {
    error = WriteAll(file_.get(), bytes_.data(), bytes_.size());
    if (error == 0) {
      written_.Set(scans_ + commands_);
    } else {
      error_.store(error, std::memory_order_release);
    }
  }
  bytes_.clear();
}

template <class Record>
void DeviceRecorder::Append(const Record& record) {
  std::array<std::uint8_t, kRecordSizeMax> bytes;
  const std::size_t size = EncodeRecord(record, bytes.data());
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
}

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
