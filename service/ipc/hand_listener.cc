#include "service/ipc/listener.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "service/ipc/peer.h"
#include "service/protocol/packet_socket.h"
#include "service/protocol/socket_path.h"

namespace omni::ipc {
namespace {

constexpr int kWaitingMax = 4;

base::Error HandSocketError(const std::string& path, const std::string& why) {
  return {"the hand's socket " + path + ": " + why};
}

std::string FolderProblem(const std::string& path) {
  if (!protocol::PathProblem(path).empty()) return "give the absolute path of a file, at most 107 bytes";
  const std::string folder = protocol::FolderOf(path);
  if (protocol::CheckFolder(folder).state == protocol::FolderState::kGood) return {};
  return folder + " must be a folder of your own that no other user can enter: mkdir -p -m 700 " + folder;
}

// Only a socket without a process behind it is removed.
std::string MakeRoom(const std::string& path) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) return errno == ENOENT ? "" : std::strerror(errno);
  if (!S_ISSOCK(info.st_mode)) return "exists and is not a socket; remove it or give another path";
  const base::UniqueFd probe(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const protocol::SocketAddress at = protocol::AddressOf(path);
  if (probe && ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes) == 0) {
    return "another twin listens there; give another path";
  }
  return ::unlink(path.c_str()) == 0 ? "" : std::strerror(errno);
}

}  // namespace

base::Result<std::unique_ptr<HandListener>> HandListener::Open(const std::string& path) {
  if (const std::string why = FolderProblem(path); !why.empty()) return HandSocketError(path, why);
  if (const std::string why = MakeRoom(path); !why.empty()) return HandSocketError(path, why);
  base::UniqueFd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const protocol::SocketAddress at = protocol::AddressOf(path);
  if (!socket || ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes) != 0) {
    return HandSocketError(path, std::strerror(errno));
  }
  std::unique_ptr<HandListener> listener(new HandListener(path, std::move(socket)));
  if (::chmod(path.c_str(), 0600) != 0 || ::listen(listener->socket_.get(), kWaitingMax) != 0) {
    return HandSocketError(path, std::strerror(errno));
  }
  return listener;
}

HandListener::~HandListener() { ::unlink(path_.c_str()); }

void HandListener::Accept() noexcept {
  if (leader_) return;
  base::UniqueFd socket(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (socket && CredentialsOf(socket.get()).uid == ::geteuid()) leader_ = std::move(socket);
}

std::optional<protocol::HandAim> HandListener::Poll() noexcept {
  Accept();
  std::optional<protocol::HandAim> newest;
  for (int i = 0; i < kAimsPerPoll && leader_; ++i) {
    std::byte packet[sizeof(protocol::HandAim) + 1];
    const protocol::Received received = protocol::ReceivePacket(leader_.get(), packet, sizeof(packet));
    if (received.result == protocol::ReceiveResult::kNothing) break;
    protocol::HandAim aim;
    if (received.result == protocol::ReceiveResult::kPacket && protocol::ReadHandAim(packet, received.size, aim)) {
      newest = aim;
    } else {
      leader_.Reset();
    }
  }
  return newest;
}

}  // namespace omni::ipc
