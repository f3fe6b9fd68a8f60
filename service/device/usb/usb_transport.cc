#include "service/device/usb/usb_transport.h"

#include <utility>

#include "service/device/usb/usb_session.h"

namespace omni::device {
namespace {

class UsbTransport final : public Transport {
 public:
  UsbTransport(std::unique_ptr<UsbSession> session, std::unique_ptr<UsbLink> link, TransportInfo info)
      : info_(std::move(info)), session_(std::move(session)), link_(std::move(link)) {}

  ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept override {
    return session_->Read(scan, timeout_ns);
  }
  bool Write(const base::CoilCurrents& currents) noexcept override { return session_->Write(currents); }
  const TransportInfo& info() const noexcept override { return info_; }
  TransportCounters counters() const noexcept override { return session_->counters(); }
  TransportState state() const noexcept override { return session_->state(); }
  bool PopNote(BaseNote& note) noexcept override { return session_->PopNote(note); }

 private:
  TransportInfo info_;
  std::unique_ptr<UsbSession> session_;
  std::unique_ptr<UsbLink> link_;  // calls the session: destroyed first
};

base::Error NoHello(const std::string& name, wire::Status last_refused) {
  if (last_refused == wire::Status::kOk) {
    return {name +
            ": no HELLO in time: unplug it, wait a second and plug it in again; if that does not help, flash its "
            "firmware again (omni device flash-help)"};
  }
  return {name + ": sends frames but no HELLO (last one: " + wire::StatusName(last_refused) +
          "): flash the firmware of this version (omni device flash-help)"};
}

}  // namespace

base::Result<std::unique_ptr<Transport>> MakeUsbTransport(UsbBus& bus, const std::string& serial,
                                                          std::int64_t hello_timeout_ns) {
  const base::Result<std::vector<UsbBase>> bases = bus.ListBases();
  if (!bases.ok()) return base::Error{bases.error()};
  const base::Result<UsbBase> chosen = ChooseUsbBase(*bases, serial);
  if (!chosen.ok()) return base::Error{chosen.error()};
  const std::string name = UsbBaseName(*chosen);
  if (!chosen->problem.empty()) return base::Error{name + ": " + chosen->problem};
  base::Result<std::unique_ptr<UsbLink>> link = bus.Open(*chosen);
  if (!link.ok()) return base::Error{name + ": " + link.error()};
  auto session = std::make_unique<UsbSession>();
  session->Attach(**link);
  if (const base::Status started = (*link)->Start(*session); !started.ok()) {
    return base::Error{name + ": " + started.error()};
  }
  const UsbSession::Hello hello = session->WaitForHello(hello_timeout_ns);
  const wire::Status last_refused = session->last_refused();
  base::Result<DeviceInfo> info = base::Error{};
  if (hello == UsbSession::Hello::kHere) info = InfoFromHello(session->hello(), Clocks::kAny);
  if (hello != UsbSession::Hello::kHere || !info.ok()) {
    link->reset();  // its thread calls the session
    if (hello == UsbSession::Hello::kGone) return base::Error{name + ": unplugged while it was being opened"};
    if (hello == UsbSession::Hello::kMissing) return NoHello(name, last_refused);
    return base::Error{name + ": " + info.error()};
  }
  session->Begin(*info);
  TransportInfo reported{.name = "usb " + chosen->port,
                         .serial = info->serial,
                         .simulation = info->simulation,
                         .field_range_T = info->field_range_T};
  return std::unique_ptr<Transport>(
      std::make_unique<UsbTransport>(std::move(session), std::move(*link), std::move(reported)));
}

}  // namespace omni::device
