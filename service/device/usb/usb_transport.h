// A base on USB: the vendor interface of firmware/wire/usb_ids.h, one frame a transfer.
//
// Read: the newest telemetry wins, stamped on CLOCK_MONOTONIC whatever clock the base has. Write: the newest set-points
// win; it hands them over and never waits. Until the base is armed they are not sent, but the base hears that its host
// is alive. Arming goes by itself, also again when it was lost because of the host; after any other fault a person has
// to look (TransportState::waits_for_person). An unplugged base is kGone; whoever wants it back opens it again.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/device/transport.h"
#include "service/device/usb/usb_bus.h"

namespace omni::device {

inline constexpr std::int64_t kUsbHelloTimeout_ns = 1'000'000'000;

// `serial` empty: the only base there is. Waits up to `hello_timeout_ns` for its HELLO.
base::Result<std::unique_ptr<Transport>> MakeUsbTransport(UsbBus& bus, const std::string& serial,
                                                          std::int64_t hello_timeout_ns = kUsbHelloTimeout_ns);

}  // namespace omni::device
