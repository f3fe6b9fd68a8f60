// A base at the other end of a SOCK_SEQPACKET socket: one datagram is one frame of firmware/wire.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/device/transport.h"

namespace omni::device {

// Waits up to `hello_timeout_ns` for the base's HELLO. `name` is shown to users (TransportInfo).
//
// Read: the newest telemetry wins. Older frames still queued are superseded (counted), gaps of the device's sequence
// are missed (counted), frames that fail a check are dropped (counted).
base::Result<std::unique_ptr<Transport>> MakeSocketTransport(base::UniqueFd socket, const std::string& name,
                                                             std::int64_t hello_timeout_ns);

}  // namespace omni::device
