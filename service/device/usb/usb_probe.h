// Examines one base without driving it, for the command line: identity, measurements, recorded fault, whether it can be
// armed. Not for the tick: its frames are received under a lock.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/wire/messages.h"
#include "service/base/result.h"
#include "service/device/usb/usb_bus.h"

namespace omni::device {

struct UsbProbeOptions {
  std::int64_t listen_ns = 500'000'000;  // to telemetry, after the HELLO
  bool arm = false;                      // afterwards, with set-points of mode off; the base then disarms by itself
};

struct UsbProbe {
  wire::Hello hello;
  wire::Telemetry telemetry;  // the newest
  std::uint64_t frames = 0;   // telemetry while listening
  std::uint64_t missed = 0;   // of them, by the sequence
  std::uint64_t bad_frames = 0;
  double listened_s = 0;                       // from the first to the last of them, by the base's clock
  std::uint8_t fresh_sensors = 0;              // bit i: sensor i had a new sample while listening
  std::uint32_t saturated_mask = 0;            // of any of them
  std::optional<wire::FaultEvent> kept_fault;  // none: the base did not answer, or has recorded none
  // With `arm`: the result. A refusal names its causes.
  bool armed = false;
  std::uint32_t refused_by = 0;                  // wire::Fault
  wire::State armed_state = wire::State::kBoot;  // what telemetry said at the end
};

// Claims the interface: not while omnid runs.
base::Result<UsbProbe> ProbeUsbBase(UsbBus& bus, const UsbBase& base, const UsbProbeOptions& options);

// HELLO by endpoint 0: also while omnid runs.
base::Result<wire::Hello> AskUsbHello(UsbBus& bus, const UsbBase& base);

// Coils off now, until the base is armed again: also while omnid runs. `reason` is for the base's fault record.
base::Status StopUsbBase(UsbBus& bus, const UsbBase& base, std::uint8_t reason);

}  // namespace omni::device
