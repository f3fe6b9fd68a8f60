// A look at one base without driving it, for people: who it is, what it measures, which fault it kept, whether it can
// be armed. Not for the tick: its frames are taken under a lock.
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
  bool arm = false;                      // afterwards, with set-points of mode off; then it is left to fall asleep
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
  std::optional<wire::FaultEvent> kept_fault;  // none: the base did not answer, or has kept none
  // With `arm`: what came of it. A refusal names what is in the way.
  bool armed = false;
  std::uint32_t refused_by = 0;                  // wire::Fault
  wire::State armed_state = wire::State::kBoot;  // what telemetry said at the end
};

// Claims the interface: not while omnid runs.
base::Result<UsbProbe> ProbeUsbBase(UsbBus& bus, const UsbBase& base, const UsbProbeOptions& options);

// HELLO by endpoint 0: also while omnid runs.
base::Result<wire::Hello> AskUsbHello(UsbBus& bus, const UsbBase& base);

// Coils off now, until somebody arms again: also while omnid runs. `reason` is for the base's fault record.
base::Status StopUsbBase(UsbBus& bus, const UsbBase& base, std::uint8_t reason);

}  // namespace omni::device
