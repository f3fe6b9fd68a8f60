#include "service/client/dial.h"

#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "service/protocol/packet_socket.h"
#include "service/protocol/socket_path.h"

namespace omni::client {
namespace {

using base::Error;
using base::UniqueFd;

std::string ConnectProblem(const ServerWords& server, const std::string& path, int error) {
  switch (error) {
    case ENOENT:
      return "no " + server.name + " at " + path + ": " + server.remedy;
    case ECONNREFUSED:
      return "no " + server.name + " behind " + path +
             " (its socket was left behind by a dead process): " + server.remedy;
    case EAGAIN:
      return server.name + " at " + path + " is too busy to accept a connection";
    default:
      return "cannot connect to " + server.name + " at " + path + ": " + std::strerror(error);
  }
}

}  // namespace

base::Result<UniqueFd> Dial(const std::string& socket_path, const ServerWords& server) {
  if (std::string problem = protocol::PathProblem(socket_path); !problem.empty()) return Error{std::move(problem)};
  protocol::FolderCheck folder = protocol::CheckFolder(protocol::FolderOf(socket_path));
  if (folder.state == protocol::FolderState::kMissing) return Error{ConnectProblem(server, socket_path, ENOENT)};
  if (folder.state == protocol::FolderState::kRefused) return Error{std::move(folder.problem)};

  UniqueFd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket) return Error{std::string("cannot make a socket: ") + std::strerror(errno)};
  const protocol::SocketAddress to = protocol::AddressOf(socket_path);
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&to.address), to.bytes) != 0) {
    return Error{ConnectProblem(server, socket_path, errno)};
  }
  ucred peer{};
  socklen_t bytes = sizeof(peer);
  if (::getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &peer, &bytes) != 0 || peer.uid != ::geteuid()) {
    return Error{"the server at " + socket_path + " runs as user " + std::to_string(peer.uid) + ", not as user " +
                 std::to_string(::geteuid()) + "; stop it or set OMNI_SOCKET"};
  }
  return socket;
}

bool HandLink::Connect() {
  if (socket_) return true;
  auto socket = Dial(path_, {.name = "twin", .remedy = "start omnid --device twin --twin-hand " + path_});
  problem_ = socket.ok() ? std::string() : socket.error();
  if (socket.ok()) socket_ = std::move(*socket);
  return connected();
}

bool HandLink::Send(const protocol::HandAim& aim) noexcept {
  if (!socket_) return false;
  if (protocol::SendPacket(socket_.get(), &aim, sizeof(aim)) == protocol::SendResult::kGone) socket_.Reset();
  return connected();
}

}  // namespace omni::client
