#include "service/device/socket_transport.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

#include "firmware/wire/messages.h"
#include "service/base/clock.h"
#include "service/device/commands.h"
#include "service/device/scan_conversion.h"
#include "service/device/transport.h"

namespace omni::device {
namespace {

constexpr int kDrainMax = 256;  // frames read in one Read, so that a flooding peer cannot block the caller

enum class Receive : std::uint8_t { kFrame, kEmpty, kGone };

struct Received {
  Receive what = Receive::kEmpty;
  std::size_t size = 0;  // of the datagram, may exceed the buffer
};

using Buffer = std::array<std::uint8_t, wire::kFrameSizeMax + 1>;

Received ReceiveFrame(int fd, Buffer& buffer) noexcept {
  for (;;) {
    const ssize_t size = recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_TRUNC);
    if (size > 0) return {Receive::kFrame, static_cast<std::size_t>(size)};
    if (size == 0) return {Receive::kGone, 0};
    if (errno == EINTR) continue;
    return {errno == EAGAIN || errno == EWOULDBLOCK ? Receive::kEmpty : Receive::kGone, 0};
  }
}

// Until readable, hung up or `deadline_ns`. False: the deadline has passed.
bool WaitReadable(int fd, std::int64_t deadline_ns) noexcept {
  const std::int64_t left_ns = deadline_ns - base::MonotonicNow_ns();
  if (left_ns <= 0) return false;
  const timespec timeout{left_ns / 1'000'000'000, left_ns % 1'000'000'000};
  pollfd poll{fd, POLLIN, 0};
  return ppoll(&poll, 1, &timeout, nullptr) != 0;  // after an interruption (-1) the caller checks again
}

wire::Status OpenReceived(const Buffer& buffer, std::size_t size, wire::FrameView& view) noexcept {
  return size > buffer.size() ? wire::Status::kTooLong : wire::OpenFrame(buffer.data(), size, view);
}

class SocketTransport final : public Transport {
 public:
  SocketTransport(base::UniqueFd socket, const std::string& name, DeviceInfo device)
      : socket_(std::move(socket)), device_(std::move(device)) {
    info_.name = name;
    info_.serial = device_.serial;
    info_.simulation = device_.simulation;
    info_.field_range_T = device_.field_range_T;
  }

  ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept override {
    const std::int64_t deadline_ns = base::MonotonicNow_ns() + timeout_ns;
    for (;;) {
      const Drained drained = Drain(scan);
      if (drained.scan) return ReadStatus::kScan;
      if (drained.gone) return ReadStatus::kGone;
      if (!WaitReadable(socket_.get(), deadline_ns)) return ReadStatus::kTimeout;
    }
  }

  bool Write(const base::CoilCurrents& currents) noexcept override {
    wire::Command command;
    command.mode = wire::Mode::kCurrent;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      command.set_point_A[k] = static_cast<float>(currents.current_A[k]);
    }
    command.time_to_live_ms = TimeToLive_ms(command.set_point_A);
    command.host_us = static_cast<std::uint64_t>(base::MonotonicNow_ns() / 1000);
    command.echo_device_us = newest_device_us_;
    std::array<std::uint8_t, wire::FrameSize<wire::Command>()> frame;
    const wire::Encoded encoded = wire::EncodeCommand(command, static_cast<float>(device_.current_max_A), command_seq_,
                                                      frame.data(), frame.size());
    if (encoded.status != wire::Status::kOk ||
        send(socket_.get(), frame.data(), encoded.size, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
      ++counters_.send_failed;
      return false;
    }
    response_.OnSent(command_seq_++, newest_device_us_);
    ++counters_.sent;
    return true;
  }

  const TransportInfo& info() const noexcept override { return info_; }
  TransportCounters counters() const noexcept override { return counters_.Snapshot(); }
  bool PopNote(BaseNote& note) noexcept override { return notes_.Pop(note); }

 private:
  struct Drained {
    bool scan = false;
    bool gone = false;
  };

  // Reads all queued frames; the newest telemetry ends up in `scan`.
  Drained Drain(base::HallScan& scan) noexcept {
    Drained drained;
    for (int i = 0; i < kDrainMax; ++i) {
      const Received received = ReceiveFrame(socket_.get(), buffer_);
      drained.gone = received.what == Receive::kGone;
      if (received.what != Receive::kFrame) break;
      const bool is_scan = Accept(received.size, scan);
      if (device_.arming) SendArm();
      if (!is_scan) continue;
      if (drained.scan) ++counters_.superseded;
      drained.scan = true;
    }
    return drained;
  }

  bool Accept(std::size_t size, base::HallScan& scan) noexcept {
    wire::FrameView view;
    const wire::Status opened = OpenReceived(buffer_, size, view);
    if (opened == wire::Status::kUnknownType) return false;
    if (opened == wire::Status::kOk && view.header.type != wire::MessageType::kTelemetry) {
      if (sequence_.Advance(view.header.seq)) ++answers_;
      if (view.header.type == wire::MessageType::kArm) TakeArm(view);
      if (view.header.type == wire::MessageType::kFault || view.header.type == wire::MessageType::kLog) KeepNote(view);
      return false;
    }
    wire::Telemetry telemetry;
    if (opened != wire::Status::kOk || wire::Decode(view, telemetry) != wire::Status::kOk ||
        !sequence_.Advance(view.header.seq)) {
      ++counters_.bad_frames;
      return false;
    }
    ++counters_.received;
    counters_.missed.Set(sequence_.missed());
    newest_device_us_ = view.header.t_device_us;
    if (device_.arming) arming_.OnTelemetry(telemetry, base::MonotonicNow_ns());
    response_.OnTelemetry(telemetry);
    scan = ScanFromTelemetry(device_, telemetry, newest_device_us_, sequence_.sequence() - answers_);
    scan.response_ns = response_.late_ns();
    return true;
  }

  // An unsolicited answer is a bad frame.
  void TakeArm(const wire::FrameView& view) noexcept {
    wire::Arm arm;
    if (wire::Decode(view, arm) != wire::Status::kOk || !arming_.OnArm(arm, base::MonotonicNow_ns())) {
      ++counters_.bad_frames;
    }
  }

  void KeepNote(const wire::FrameView& view) noexcept {
    if (notes_.Add(view) != wire::Status::kOk) ++counters_.bad_frames;
  }

  void SendArm() noexcept {
    wire::Arm arm;
    if (!arming_.NextToSend(base::MonotonicNow_ns(), arm)) return;
    std::array<std::uint8_t, wire::FrameSize<wire::Arm>()> frame;
    const wire::Encoded encoded = wire::Encode(arm, arm_seq_++, 0, frame.data(), frame.size());
    if (send(socket_.get(), frame.data(), encoded.size, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) ++counters_.send_failed;
  }

  base::UniqueFd socket_;
  DeviceInfo device_;
  TransportInfo info_;
  Counters counters_;
  SequenceCounter sequence_;
  std::uint64_t answers_ = 0;  // frames between telemetry
  Buffer buffer_{};
  std::uint64_t newest_device_us_ = 0;
  std::uint16_t command_seq_ = 0, arm_seq_ = 0;
  Arming arming_;
  ResponseTime response_;
  BaseNotes notes_;
};

// Why there is no connection; `seen` describes the last frame.
enum class NoHello : std::uint8_t { kClosed, kSilent, kOtherFrames };

base::Error Explain(NoHello why, const std::string& name, const std::string& seen) {
  switch (why) {
    case NoHello::kClosed:
      return {name + ": the device closed the connection before its HELLO (" + seen + "): see its own messages above"};
    case NoHello::kSilent:
      return {name + ": no HELLO in time (" + seen + "): is it powered, and is another program holding it?"};
    case NoHello::kOtherFrames:
      return {name + ": sends frames but no HELLO (" + seen + "): wrong firmware?"};
  }
  return {name};
}

base::Result<std::unique_ptr<Transport>> Connect(base::UniqueFd socket, const std::string& name,
                                                 const wire::Hello& hello) {
  base::Result<DeviceInfo> device = InfoFromHello(hello);
  if (!device) return base::Error{name + ": " + device.error()};
  return std::unique_ptr<Transport>(
      std::make_unique<SocketTransport>(std::move(socket), name, std::move(device.value())));
}

}  // namespace

base::Result<std::unique_ptr<Transport>> MakeSocketTransport(base::UniqueFd socket, const std::string& name,
                                                             std::int64_t hello_timeout_ns) {
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + hello_timeout_ns;
  std::string seen = "nothing arrived";
  Buffer buffer{};
  for (;;) {
    const Received received = ReceiveFrame(socket.get(), buffer);
    if (received.what == Receive::kGone) return Explain(NoHello::kClosed, name, seen);
    if (received.what == Receive::kEmpty) {
      if (!WaitReadable(socket.get(), deadline_ns)) return Explain(NoHello::kSilent, name, seen);
      continue;
    }
    wire::FrameView view;
    wire::Hello hello;
    wire::Status status = OpenReceived(buffer, received.size, view);
    if (status == wire::Status::kOk) status = wire::Decode(view, hello);
    if (status == wire::Status::kOk) return Connect(std::move(socket), name, hello);
    seen = "last frame: ";
    seen += wire::StatusName(status);
    if (base::MonotonicNow_ns() >= deadline_ns) return Explain(NoHello::kOtherFrames, name, seen);
  }
}

}  // namespace omni::device
