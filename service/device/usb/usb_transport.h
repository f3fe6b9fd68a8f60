// A base on USB: the vendor interface of firmware/wire/usb_ids.h, one frame a transfer.
//
// Read: the newest telemetry wins, stamped on CLOCK_MONOTONIC whatever clock the base has. Write: the newest set-points
// win; it passes them on and never waits. Until the base is armed they are not sent, but the base is shown that its
// host is alive. Arming is automatic, also after it was lost because of the host; after any other fault the user has to
// check the base (TransportState::waits_for_person). An unplugged base is kGone; the caller may open it again.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/device/transport.h"
#include "service/device/usb/usb_bus.h"

namespace omni::device {

inline constexpr std::int64_t kUsbHelloTimeout_ns = 1'000'000'000;

// `serial` empty: the only base connected. Waits up to `hello_timeout_ns` for its HELLO.
base::Result<std::unique_ptr<Transport>> MakeUsbTransport(UsbBus& bus, const std::string& serial,
                                                          std::int64_t hello_timeout_ns = kUsbHelloTimeout_ns);

}  // namespace omni::device
