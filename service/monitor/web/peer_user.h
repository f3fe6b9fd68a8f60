// Whose program is at the other end of a TCP connection within this machine, as the kernel knows it.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>

namespace omni::monitor {

// The user of the socket on 127.0.0.1:`from` that is connected to 127.0.0.1:`to`, from /proc/net/tcp [proc(5)]. Empty:
// there is none any more.
std::optional<uid_t> UserOfLoopback(std::uint16_t from, std::uint16_t to);

}  // namespace omni::monitor
