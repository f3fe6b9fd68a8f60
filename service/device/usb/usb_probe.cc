#include "service/device/usb/usb_probe.h"

#include <memory>
#include <mutex>
#include <utility>

#include "service/base/clock.h"
#include "service/device/commands.h"
#include "service/device/scan_conversion.h"
#include "service/device/usb/ready_event.h"

namespace omni::device {
namespace {

constexpr std::int64_t kHelloTimeout_ns = 1'000'000'000;
constexpr std::int64_t kFaultTimeout_ns = 200'000'000;
constexpr std::int64_t kArmTimeout_ns = 5'000'000'000;  // a self-test may come first
constexpr std::int64_t kCommandPeriod_ns = 5'000'000;

class Prober final : public UsbHandler {
 public:
  void OnFrame(const std::uint8_t* data, std::size_t size, std::int64_t t_ns) noexcept override {
    const std::lock_guard lock(mutex_);
    wire::FrameView view;
    const wire::Status opened = wire::OpenFrame(data, size, view);
    if (opened == wire::Status::kUnknownType) return;
    const bool good = opened == wire::Status::kOk && sequence_.Advance(view.header.seq) && Take(view, t_ns);
    if (!good) ++probe_.bad_frames;
    ready_.Signal();
  }
  std::size_t NextFrame(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept override {
    const std::lock_guard lock(mutex_);
    if (wants_hello_ && t_ns >= hello_next_ns_) {
      hello_next_ns_ = t_ns + kFaultTimeout_ns / 2;
      return Empty(wire::MessageType::kHello, frame, capacity);
    }
    if (std::exchange(wants_fault_, false)) return Empty(wire::MessageType::kFault, frame, capacity);
    wire::Arm arm;
    const bool heard = alive_next_ns_ != 0;  // a base that has not heard its host yet would refuse
    if (arms_ && heard && arming_.NextToSend(t_ns, arm)) return wire::Encode(arm, seq_++, 0, frame, capacity).size;
    return arms_ ? Alive(t_ns, frame, capacity) : 0;
  }
  void OnSendFailed() noexcept override {}
  void OnInterrupted() noexcept override {}
  void OnGone() noexcept override {
    const std::lock_guard lock(mutex_);
    gone_ = true;
    ready_.Signal();
  }

  // Until `holds` (under the lock), the base is gone or `timeout_ns` is over; returns `holds` at the end.
  template <class Holds>
  bool Wait(std::int64_t timeout_ns, const Holds& holds) {
    const std::int64_t deadline_ns = base::MonotonicNow_ns() + timeout_ns;
    for (;;) {
      {
        const std::lock_guard lock(mutex_);
        if (gone_ || holds()) return holds();
      }
      if (!ready_.Wait(deadline_ns)) {
        const std::lock_guard lock(mutex_);
        return holds();
      }
    }
  }

  bool WaitForHello() {
    return Wait(kHelloTimeout_ns, [this] { return !wants_hello_; });
  }
  void Listen(std::int64_t listen_ns) {
    {
      const std::lock_guard lock(mutex_);
      listens_ = true;
    }
    Wait(listen_ns, [] { return false; });
    const std::lock_guard lock(mutex_);
    listens_ = false;
  }
  void RequestFault() {
    {
      const std::lock_guard lock(mutex_);
      wants_fault_ = true;
    }
    Wait(kFaultTimeout_ns, [this] { return probe_.kept_fault.has_value(); });
  }
  // The user requests it, so latched faults do not prevent the attempt. A base that runs its self-test first refuses
  // until it has ended; the request is repeated.
  void Arm() {
    {
      const std::lock_guard lock(mutex_);
      arms_ = true;
    }
    Wait(kArmTimeout_ns, [this] { return probe_.armed || arm_refused_; });
  }
  bool gone() {
    const std::lock_guard lock(mutex_);
    return gone_;
  }
  UsbProbe result() {
    const std::lock_guard lock(mutex_);
    return probe_;
  }

 private:
  std::size_t Empty(wire::MessageType type, std::uint8_t* frame, std::size_t capacity) noexcept {
    wire::Header header;
    header.type = type;
    header.seq = seq_++;
    return wire::SealFrame(header, 0, frame, capacity).size;
  }

  std::size_t Alive(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept {
    if (t_ns < alive_next_ns_) return 0;
    alive_next_ns_ = t_ns + kCommandPeriod_ns;
    wire::Command off;
    off.host_us = static_cast<std::uint64_t>(t_ns / 1000);
    return wire::EncodeCommand(off, probe_.hello.current_max_A, seq_++, frame, capacity).size;
  }

  bool Take(const wire::FrameView& view, std::int64_t t_ns) noexcept {
    switch (view.header.type) {
      case wire::MessageType::kHello:
        if (wire::Decode(view, probe_.hello) != wire::Status::kOk) return false;
        wants_hello_ = false;
        return true;
      case wire::MessageType::kTelemetry:
        return TakeTelemetry(view, t_ns);
      case wire::MessageType::kFault:
        return TakeFault(view);
      case wire::MessageType::kArm:
        return TakeArm(view, t_ns);
      default:
        return true;
    }
  }

  bool TakeTelemetry(const wire::FrameView& view, std::int64_t t_ns) noexcept {
    wire::Telemetry telemetry;
    if (wire::Decode(view, telemetry) != wire::Status::kOk) return false;
    if (!std::exchange(seq_known_, true)) seq_ = static_cast<std::uint16_t>(telemetry.ack_seq + kSeqMargin);
    probe_.telemetry = telemetry;
    probe_.armed_state = telemetry.state;
    if (listens_) Listened(telemetry, view.header);
    if (arms_) {
      wire::Telemetry asked = telemetry;
      asked.faults = 0;  // see Arm
      if (telemetry.state == wire::State::kArmed) probe_.armed = true;
      arming_.OnTelemetry(asked, t_ns);
    }
    return true;
  }

  void Listened(const wire::Telemetry& telemetry, const wire::Header& header) noexcept {
    if (probe_.frames++ == 0) {
      first_us_ = header.t_device_us;
      missed_before_ = sequence_.missed();
    }
    probe_.missed = sequence_.missed() - missed_before_;
    probe_.fresh_sensors |= telemetry.fresh_mask;
    probe_.saturated_mask |= telemetry.saturated_mask;
    probe_.listened_s = 1e-6 * static_cast<double>(header.t_device_us - first_us_);
  }

  bool TakeFault(const wire::FrameView& view) noexcept {
    wire::FaultEvent event;
    if (wire::Decode(view, event) != wire::Status::kOk) return false;
    if (event.fault != 0 && event.after_reset != 0) probe_.kept_fault = event;
    return true;
  }

  bool TakeArm(const wire::FrameView& view, std::int64_t t_ns) noexcept {
    wire::Arm arm;
    if (wire::Decode(view, arm) != wire::Status::kOk) return false;
    if (arms_ && arm.step == wire::ArmStep::kRefused) {
      arm_refused_ = (arm.faults & ~(wire::kFaultsOfTheHost | wire::kFaultSelfTest)) != 0;
      probe_.refused_by = arm.faults;
    }
    return !arms_ || arming_.OnArm(arm, t_ns);
  }

  UsbProbe probe_;
  ReadyEvent ready_;
  std::mutex mutex_;
  Arming arming_;
  bool gone_ = false, wants_hello_ = true, wants_fault_ = false, listens_ = false, arms_ = false, arm_refused_ = false;
  bool seq_known_ = false;
  std::int64_t hello_next_ns_ = 0, alive_next_ns_ = 0;
  SequenceCounter sequence_;
  std::uint64_t first_us_ = 0;
  std::uint64_t missed_before_ = 0;
  std::uint16_t seq_ = 0;
};

base::Error Named(const UsbBase& base, const std::string& problem) { return {UsbBaseName(base) + ": " + problem}; }

}  // namespace

base::Result<UsbProbe> ProbeUsbBase(UsbBus& bus, const UsbBase& base, const UsbProbeOptions& options) {
  base::Result<std::unique_ptr<UsbLink>> link = bus.Open(base);
  if (!link.ok()) return Named(base, link.error());
  Prober prober;
  const std::unique_ptr<UsbLink> held = std::move(*link);  // goes before the prober, whom it calls
  if (const base::Status started = held->Start(prober); !started.ok()) return Named(base, started.error());
  if (!prober.WaitForHello()) {
    return Named(base, prober.gone() ? "unplugged while it was being probed"
                                     : "no HELLO in time: unplug it and plug it in again, or flash its firmware again "
                                       "(omni device flash-help)");
  }
  prober.Listen(options.listen_ns);
  prober.RequestFault();
  if (options.arm) prober.Arm();
  if (prober.gone()) return Named(base, "unplugged while it was being probed");
  return prober.result();
}

base::Result<wire::Hello> AskUsbHello(UsbBus& bus, const UsbBase& base) {
  const base::Result<std::vector<std::uint8_t>> answer = bus.ControlIn(base, wire::UsbRequest::kHello);
  if (!answer.ok()) return Named(base, answer.error());
  wire::FrameView view;
  wire::Hello hello;
  wire::Status status = wire::OpenFrame(answer->data(), answer->size(), view);
  if (status == wire::Status::kOk) status = wire::Decode(view, hello);
  if (status == wire::Status::kOk) return hello;
  return Named(base, std::string("sent an invalid HELLO (") + wire::StatusName(status) +
                         "): flash the right firmware (omni device flash-help)");
}

base::Status StopUsbBase(UsbBus& bus, const UsbBase& base, std::uint8_t reason) {
  const base::Status stopped = bus.ControlOut(base, wire::UsbRequest::kEstop, reason);
  if (!stopped.ok()) return Named(base, stopped.error());
  return base::Ok{};
}

}  // namespace omni::device
