#include "service/ipc/listener.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace omni::ipc {
namespace {

using base::Error;
using base::UniqueFd;

constexpr int kFirstFd = 3;  // SD_LISTEN_FDS_START

// 0: unset, or no number.
int NumberIn(const char* variable) {
  const char* text = std::getenv(variable);
  int number = 0;
  if (text != nullptr) std::from_chars(text, text + std::strlen(text), number);
  return number;
}

int SocketOption(int fd, int option) {
  int value = -1;
  socklen_t bytes = sizeof(value);
  return ::getsockopt(fd, SOL_SOCKET, option, &value, &bytes) == 0 ? value : -1;
}

// Empty: no path.
std::string PathOf(int fd) {
  sockaddr_un address{};
  socklen_t bytes = sizeof(address);
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &bytes) != 0 || address.sun_family != AF_UNIX) return {};
  if (bytes <= offsetof(sockaddr_un, sun_path)) return {};
  const std::size_t room = std::min<std::size_t>(bytes - offsetof(sockaddr_un, sun_path), sizeof(address.sun_path));
  return {address.sun_path, ::strnlen(address.sun_path, room)};
}

}  // namespace

base::Result<std::optional<InheritedSocket>> TakeInheritedSocket() {
  const bool ours = NumberIn("LISTEN_PID") == ::getpid();
  const int count = NumberIn("LISTEN_FDS");
  for (const char* variable : {"LISTEN_PID", "LISTEN_FDS", "LISTEN_FDNAMES"}) ::unsetenv(variable);
  if (!ours || count <= 0) return std::optional<InheritedSocket>();
  if (count > 1) {
    return Error{"systemd passes " + std::to_string(count) +
                 " sockets, must be 1; see systemctl --user cat omnid.socket"};
  }
  InheritedSocket socket{.fd = UniqueFd(kFirstFd), .path = PathOf(kFirstFd)};
  if (SocketOption(kFirstFd, SO_TYPE) != SOCK_SEQPACKET || SocketOption(kFirstFd, SO_ACCEPTCONN) != 1 ||
      socket.path.empty()) {
    return Error{
        "the socket that systemd passes is not one of ListenSequentialPacket= with a path; see systemctl --user cat "
        "omnid.socket"};
  }
  ::fcntl(kFirstFd, F_SETFD, FD_CLOEXEC);
  ::fcntl(kFirstFd, F_SETFL, ::fcntl(kFirstFd, F_GETFL) | O_NONBLOCK);
  return std::optional<InheritedSocket>(std::move(socket));
}

}  // namespace omni::ipc
