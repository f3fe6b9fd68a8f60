#include "service/ipc/peer.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "service/protocol/text.h"

namespace omni::ipc {
namespace {

using base::UniqueFd;
using protocol::SendResult;

constexpr int kSoPeerPidfd = 77;  // SO_PEERPIDFD, Linux 6.5: names the process itself, not a number that may be reused

}  // namespace

Credentials CredentialsOf(int socket) noexcept {
  ucred peer{};
  socklen_t bytes = sizeof(peer);
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &bytes) != 0) return {};
  return {peer.uid, peer.pid};
}

ProcessWatch WatchProcess(int socket, pid_t pid) noexcept {
  int fd = -1;
  socklen_t bytes = sizeof(fd);
  if (::getsockopt(socket, SOL_SOCKET, kSoPeerPidfd, &fd, &bytes) == 0) return {UniqueFd(fd), false};
  if (pid <= 0) return {};
  fd = static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  const bool dead = fd < 0 && errno == ESRCH;
  return {UniqueFd(fd), dead};
}

Peer::Peer(ClientId id, UniqueFd socket, UniqueFd process, pid_t pid, std::int64_t now_ns)
    : socket_(std::move(socket)), process_(std::move(process)), accepted_ns_(now_ns) {
  info_.id = id;
  info_.pid = pid;
}

base::Status Peer::Greet(const protocol::Hello& hello, std::uint64_t service_instance, int state_fd) {
  auto page = base::MakeSealedMemory("omni-life", protocol::kLifePageBytes, PROT_READ, base::kSealsFixedSize);
  if (!page) return base::Error{page.error()};
  info_.role = hello.role;
  info_.application = protocol::Printable(hello.application);
  info_.engine = protocol::Printable(hello.engine);
  protocol::Welcome welcome;
  welcome.client_id = info_.id;
  welcome.service_instance = service_instance;
  welcome.state_bytes = sizeof(protocol::StateMemory);
  welcome.life_bytes = protocol::kLifePageBytes;
  const int fds[] = {state_fd, page->fd.get()};
  if (protocol::SendPacket(socket_.get(), &welcome, sizeof(welcome), fds, 2) != SendResult::kSent) {
    return base::Error{"Welcome could not be sent"};
  }
  const auto mapping = std::make_shared<const base::Mapping>(std::move(page->mapping));
  life_ = {mapping, static_cast<const protocol::LifePage*>(mapping->get())};
  return base::Ok{};
}

bool Peer::Send(std::string_view message, int file, protocol::Delivery delivery) noexcept {
  const SendResult result =
      protocol::SendPacket(socket_.get(), message.data(), message.size(), &file, file >= 0 ? 1 : 0);
  if (result == SendResult::kFull && delivery == protocol::Delivery::kOnce) ++dropped_;
  if (result == SendResult::kGone) doomed_ = true;
  return result == SendResult::kSent;
}

void Peer::Doom(const std::string& reason) noexcept {
  if (doomed_) return;
  doomed_ = true;
  if (!reason.empty()) SendReject(socket_.get(), reason);
}

void SendReject(int socket, const std::string& reason) noexcept {
  protocol::Reject reject;
  protocol::SetField(reject.reason, reason);
  protocol::SendPacket(socket, &reject, sizeof(reject));
}

}  // namespace omni::ipc
