#include "service/device/usb/usb_session.h"

#include <cstddef>
#include <limits>

#include "service/base/clock.h"
#include "service/device/commands.h"

namespace omni::device {
namespace {

constexpr std::int64_t kHelloRetry_ns = 100'000'000;
constexpr std::int64_t kCommandTtl_ns = std::int64_t{kCommandTimeToLive_ms} * 1'000'000;
constexpr std::int64_t kRepeat_ns = 5'000'000;  // a resting tick writes only every 16 ms, and the base waits for 20
constexpr std::int64_t kRest_ns = 100'000'000;  // a tick that writes nothing for so long is not resting but stuck
constexpr int kOutOfOrderMax = 20;  // frames in a row that are older than the last good one: the base has restarted
constexpr std::uint64_t kStampMax_us = std::numeric_limits<std::int64_t>::max() / 1000;

constexpr std::uint32_t kHeldBit = 1U << 8;

}  // namespace

UsbSession::Hello UsbSession::WaitForHello(std::int64_t timeout_ns) noexcept {
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + timeout_ns;
  for (;;) {
    if (gone_.load(std::memory_order_acquire)) return Hello::kGone;
    if (phase_.load(std::memory_order_acquire) == Phase::kHaveHello) return Hello::kHere;
    if (!ready_.Wait(deadline_ns)) return Hello::kMissing;
  }
}

void UsbSession::Begin(const DeviceInfo& device) noexcept {
  device_ = device;
  current_max_A_ = static_cast<float>(device.current_max_A);
  phase_.store(Phase::kRunning, std::memory_order_release);
}

ReadStatus UsbSession::Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept {
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + timeout_ns;
  for (;;) {
    const bool gone = gone_.load(std::memory_order_acquire);  // before the slot: its last scan is delivered first
    const ScanSlot& slot = scans_.Read();
    if (slot.index != scans_read_) {
      superseded_.Set(superseded_.value() + (slot.index - scans_read_ - 1));
      scans_read_ = slot.index;
      answered_device_us_ = slot.t_device_us;
      scan = slot.scan;
      return ReadStatus::kScan;
    }
    if (gone) return ReadStatus::kGone;
    if (!ready_.Wait(deadline_ns)) return ReadStatus::kTimeout;
  }
}

bool UsbSession::Write(const base::CoilCurrents& currents) noexcept {
  wire::Command command;
  command.mode = wire::Mode::kCurrent;
  CommandSlot slot;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    command.set_point_A[k] = slot.set_point_A[k] = static_cast<float>(currents.current_A[k]);
  }
  const bool good = wire::CheckCommand(command, current_max_A_) == wire::Status::kOk;
  if (!good || gone_.load(std::memory_order_relaxed)) {
    ++refused_set_points_;
    return false;
  }
  slot.index = ++commands_written_;
  slot.echo_device_us = answered_device_us_;
  slot.t_ns = base::MonotonicNow_ns();
  commands_.Write(slot);
  if (link_ != nullptr) link_->Wake();
  return true;
}

TransportCounters UsbSession::counters() const noexcept {
  TransportCounters now = counters_.Snapshot();
  now.superseded = superseded_.value();
  now.send_failed += refused_set_points_.value();
  now.bad_crc = bad_crc_.value();
  now.interrupted = interrupted_.value();
  return now;
}

TransportState UsbSession::state() const noexcept {
  const std::uint32_t packed = state_and_held_.load(std::memory_order_relaxed);
  return {.state = static_cast<std::uint8_t>(packed & 0xFFU),
          .waits_for_person = (packed & kHeldBit) != 0,
          .faults = faults_.load(std::memory_order_relaxed)};
}

void UsbSession::OnGone() noexcept {
  gone_.store(true, std::memory_order_release);
  ready_.Signal();
}

void UsbSession::Refuse(wire::Status status) noexcept {
  ++counters_.bad_frames;
  if (status == wire::Status::kBadCrc) ++bad_crc_;
  last_refused_.store(status, std::memory_order_relaxed);
}

// Frames of all types share one sequence: a gap is a lost frame. A base whose time or sequence numbers stay behind has
// restarted unnoticed; it is reopened, with a HELLO.
bool UsbSession::InOrder(const wire::Header& header) noexcept {
  const bool telemetry = header.type == wire::MessageType::kTelemetry;
  const bool back_in_time = telemetry && header.t_device_us < newest_device_us_;
  if (!back_in_time && sequence_.Advance(header.seq)) {
    out_of_order_ = 0;
    counters_.missed.Set(sequence_.missed());
    if (telemetry) newest_device_us_ = header.t_device_us;
    return true;
  }
  Refuse(wire::Status::kOutOfRange);
  if (++out_of_order_ == kOutOfOrderMax) OnGone();
  return false;
}

void UsbSession::OnFrame(const std::uint8_t* data, std::size_t size, std::int64_t t_ns) noexcept {
  wire::FrameView view;
  const wire::Status opened = wire::OpenFrame(data, size, view);
  if (opened == wire::Status::kUnknownType) return;
  if (opened != wire::Status::kOk) {
    Refuse(opened);
    return;
  }
  if (!InOrder(view.header)) return;
  switch (view.header.type) {
    case wire::MessageType::kHello:
      TakeHello(view);
      break;
    case wire::MessageType::kTelemetry:
      TakeTelemetry(view, t_ns);
      break;
    case wire::MessageType::kArm:
      TakeArm(view, t_ns);
      break;
    case wire::MessageType::kFault:
    case wire::MessageType::kLog:
      KeepNote(view);
      break;
    case wire::MessageType::kConfig:
      break;  // valid, but unsolicited
    case wire::MessageType::kCommand:
    case wire::MessageType::kEstop:
      Refuse(wire::Status::kWrongType);  // only a host sends these
      break;
  }
}

void UsbSession::TakeHello(const wire::FrameView& view) noexcept {
  if (phase_.load(std::memory_order_relaxed) != Phase::kRequestHello) return;  // a second answer to a repeated request
  const wire::Status status = wire::Decode(view, hello_);
  if (status != wire::Status::kOk) {
    Refuse(status);
    return;
  }
  phase_.store(Phase::kHaveHello, std::memory_order_release);
  ready_.Signal();
}

void UsbSession::TakeTelemetry(const wire::FrameView& view, std::int64_t t_ns) noexcept {
  wire::Telemetry telemetry;
  const wire::Status status = wire::Decode(view, telemetry);
  if (status != wire::Status::kOk) {
    Refuse(status);
    return;
  }
  if (!seq_known_) {
    seq_ = static_cast<std::uint16_t>(telemetry.ack_seq + kSeqMargin);
    seq_known_ = true;
  }
  if (phase_.load(std::memory_order_acquire) != Phase::kRunning) return;
  const std::uint64_t t_device_us = view.header.t_device_us;
  std::int64_t scan_t_ns = 0;
  if (!Stamp(telemetry, t_device_us, t_ns, scan_t_ns)) {
    Refuse(wire::Status::kOutOfRange);
    return;
  }
  if (device_.arming) arming_.OnTelemetry(telemetry, t_ns);
  response_.OnTelemetry(telemetry);
  ++counters_.received;
  Publish(telemetry, t_device_us, scan_t_ns);
}

// The scan's instant on the host's clock. False: no instant.
bool UsbSession::Stamp(const wire::Telemetry& telemetry, std::uint64_t t_device_us, std::int64_t t_ns,
                       std::int64_t& scan_t_ns) noexcept {
  if (t_device_us > kStampMax_us) return false;
  scan_t_ns = device_.clock_is_host ? static_cast<std::int64_t>(t_device_us) * 1000
                                    : clock_.Add({.t_device_us = t_device_us,
                                                  .received_ns = t_ns,
                                                  .ack_host_us = telemetry.ack_host_us,
                                                  .ack_rx_device_us = telemetry.ack_rx_device_us});
  return true;
}

void UsbSession::Publish(const wire::Telemetry& telemetry, std::uint64_t t_device_us, std::int64_t scan_t_ns) noexcept {
  state_and_held_.store(static_cast<std::uint32_t>(telemetry.state) | (arming_.held() ? kHeldBit : 0),
                        std::memory_order_relaxed);
  faults_.store(telemetry.faults, std::memory_order_relaxed);
  ScanSlot slot;
  slot.index = ++published_;
  slot.t_device_us = t_device_us;
  slot.scan = ScanFromTelemetry(device_, telemetry, t_device_us, published_ + sequence_.missed());
  slot.scan.t_ns = scan_t_ns;
  slot.scan.response_ns = response_.late_ns();
  scans_.Write(slot);
  ready_.Signal();
}

void UsbSession::TakeArm(const wire::FrameView& view, std::int64_t t_ns) noexcept {
  wire::Arm arm;
  const wire::Status status = wire::Decode(view, arm);
  if (status != wire::Status::kOk) {
    Refuse(status);
  } else if (!arming_.OnArm(arm, t_ns)) {
    Refuse(wire::Status::kOutOfRange);
  }
}

void UsbSession::KeepNote(const wire::FrameView& view) noexcept {
  const wire::Status status = notes_.Add(view);
  if (status != wire::Status::kOk) Refuse(status);
}

std::size_t UsbSession::RequestHello(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept {
  if (t_ns < hello_next_ns_) return 0;
  hello_next_ns_ = t_ns + kHelloRetry_ns;
  wire::Header header;
  header.type = wire::MessageType::kHello;
  header.seq = seq_++;
  return wire::SealFrame(header, 0, frame, capacity).size;
}

std::size_t UsbSession::NextFrame(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept {
  const Phase phase = phase_.load(std::memory_order_acquire);
  if (phase == Phase::kRequestHello) return RequestHello(t_ns, frame, capacity);
  if (phase != Phase::kRunning) return 0;
  wire::Arm arm;
  const bool heard = counters_.sent.value() != 0;  // a base that has not heard its host yet would refuse
  if (heard && arming_.NextToSend(t_ns, arm)) return wire::Encode(arm, seq_++, 0, frame, capacity).size;
  return NextCommand(t_ns, frame, capacity);
}

// Only a zero set-point is repeated between the writes of a resting tick: it keeps the base armed and is harmless.
bool UsbSession::Repeats(const CommandSlot& slot, std::int64_t t_ns) const noexcept {
  for (const float set_point_A : slot.set_point_A) {
    if (set_point_A != 0) return false;
  }
  return slot.index != 0 && t_ns - slot.t_ns <= kRest_ns && t_ns - command_sent_ns_ >= kRepeat_ns;
}

// The newest set-points; mode off while the base is not armed, which still shows it that its host is alive.
std::size_t UsbSession::NextCommand(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept {
  const CommandSlot& slot = commands_.Read();
  const bool fresh = slot.index != commands_taken_;
  if (!fresh && !Repeats(slot, t_ns)) return 0;
  commands_taken_ = slot.index;
  if (fresh && t_ns - slot.t_ns > kCommandTtl_ns) {  // the bus was blocked: the command is outdated
    ++counters_.send_failed;
    return 0;
  }
  wire::Command command;
  if (!device_.arming || arming_.armed()) {
    command.mode = wire::Mode::kCurrent;
    for (int k = 0; k < wire::kCoils; ++k) command.set_point_A[k] = slot.set_point_A[k];
  }
  command.time_to_live_ms = TimeToLive_ms(command.set_point_A);
  command.host_us = static_cast<std::uint64_t>(t_ns / 1000);
  command.echo_device_us = slot.echo_device_us;
  const wire::Encoded encoded = wire::EncodeCommand(command, current_max_A_, seq_, frame, capacity);
  if (encoded.status != wire::Status::kOk) {
    ++counters_.send_failed;
    return 0;
  }
  if (fresh) response_.OnSent(seq_, slot.echo_device_us);
  ++seq_;
  ++counters_.sent;
  command_sent_ns_ = t_ns;
  return encoded.size;
}

}  // namespace omni::device
