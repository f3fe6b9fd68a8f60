// Who may use the page: a browser of this machine and user that opened the address omni printed. Four checks, since a
// server on the loopback address is reachable from every program, and from every web page that the person visits:
//   user    of the other end of the connection is ours (below): other users of this machine are refused
//   Host    names the loopback address: a foreign name that resolves to it (DNS rebinding) is refused
//   Origin  is this server's own: scripts of other pages are refused
//   token   random, of this start: other programs are refused. What omni gives to a browser's command line, which every
//           user can read, is a code that is good once for the token
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "service/base/result.h"

namespace omni::monitor {

// 128 random bits in hexadecimal digits.
base::Result<std::string> MakeToken();

// In a time that does not depend on where they differ. An empty token equals nothing.
bool SameToken(std::string_view given, std::string_view token) noexcept;

// "127.0.0.1:PORT", "localhost:PORT" or "[::1]:PORT".
bool HostAllowed(std::string_view host, std::uint16_t port) noexcept;

// "http://" and an allowed host. Browsers send it with every WebSocket; other programs need not send any ("").
bool OriginAllowed(std::string_view origin, std::uint16_t port) noexcept;

// The token in an Authorization header: "Bearer TOKEN". Empty: there is none.
std::string_view BearerToken(std::string_view authorization) noexcept;

// The code in an Authorization header: "Code CODE". Empty: there is none.
std::string_view OnceCode(std::string_view authorization) noexcept;

// The token in a Sec-WebSocket-Protocol header: "omni-page, token.TOKEN". Empty: there is none.
inline constexpr std::string_view kPageProtocol = "omni-page";
std::string_view ProtocolToken(std::string_view protocols) noexcept;

// Whose program is at the other end of a TCP connection within this machine, as the kernel knows it.

// The user of the socket on 127.0.0.1:`from` that is connected to 127.0.0.1:`to`, from /proc/net/tcp [proc(5)]. Empty:
// there is none any more.
std::optional<uid_t> UserOfLoopback(std::uint16_t from, std::uint16_t to);

}  // namespace omni::monitor
