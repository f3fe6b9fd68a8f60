#include "service/protocol/packet_socket.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>
#include <cstring>

namespace omni::protocol {
namespace {

constexpr std::size_t kControlBytes = CMSG_SPACE(kMaxPassedFds * sizeof(int));

// Takes every descriptor out of `header`; those beyond `capacity` are closed. Returns how many came.
std::size_t TakeFds(msghdr& header, base::UniqueFd* fds, std::size_t capacity) noexcept {
  std::size_t count = 0;
  for (cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr; part = CMSG_NXTHDR(&header, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t in_part = (part->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < in_part; ++i) {
      int fd = -1;
      std::memcpy(&fd, CMSG_DATA(part) + i * sizeof(int), sizeof(int));
      base::UniqueFd owned(fd);
      if (count < capacity) fds[count] = std::move(owned);
      ++count;
    }
  }
  return count;
}

}  // namespace

SendResult SendPacket(int socket, const void* bytes, std::size_t size, const int* fds, std::size_t fd_count) noexcept {
  iovec part{const_cast<void*>(bytes), size};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  alignas(cmsghdr) char control[kControlBytes] = {};
  if (fd_count > 0 && fd_count <= kMaxPassedFds) {
    header.msg_control = control;
    header.msg_controllen = CMSG_SPACE(fd_count * sizeof(int));
    cmsghdr* rights = CMSG_FIRSTHDR(&header);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(fd_count * sizeof(int));
    std::memcpy(CMSG_DATA(rights), fds, fd_count * sizeof(int));
  }
  ssize_t sent = -1;
  do {
    sent = ::sendmsg(socket, &header, MSG_NOSIGNAL | MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  if (sent >= 0) return SendResult::kSent;
  const bool gone = errno == EPIPE || errno == ECONNRESET || errno == ENOTCONN || errno == EBADF;
  return gone ? SendResult::kGone : SendResult::kFull;
}

Received ReceivePacket(int socket, void* buffer, std::size_t capacity, base::UniqueFd* fds,
                       std::size_t fd_capacity) noexcept {
  iovec part{buffer, capacity};
  alignas(cmsghdr) char control[kControlBytes];
  // A peer that closes with packets of ours unread resets the socket; what it said before is still queued behind that
  // one error (unix_release_sock in Linux), e.g. the reason of a refusal.
  bool reset_seen = false;
  for (;;) {
    msghdr header{};
    header.msg_iov = &part;
    header.msg_iovlen = 1;
    header.msg_control = fd_capacity > 0 ? control : nullptr;
    header.msg_controllen = fd_capacity > 0 ? sizeof(control) : 0;
    const ssize_t size = ::recvmsg(socket, &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (size < 0) {
      if (errno == EINTR) continue;
      if (errno == EAGAIN || errno == EWOULDBLOCK) return {ReceiveResult::kNothing, 0, 0};
      if (errno != ECONNRESET || reset_seen) return {ReceiveResult::kEnd, 0, 0};
      reset_seen = true;
      continue;
    }
    const std::size_t fd_count = TakeFds(header, fds, fd_capacity);
    if (size == 0) return {ReceiveResult::kEnd, 0, 0};
    const bool too_long = (header.msg_flags & MSG_TRUNC) != 0 || fd_count > fd_capacity;
    const bool lost = (header.msg_flags & MSG_CTRUNC) != 0;  // of descriptors; with room for more: EMFILE or ENFILE
    const ReceiveResult result = too_long                         ? ReceiveResult::kTooLong
                                 : lost && fd_count < fd_capacity ? ReceiveResult::kNoRoom
                                 : lost                           ? ReceiveResult::kTooLong
                                                                  : ReceiveResult::kPacket;
    return {result, static_cast<std::size_t>(size), fd_count};
  }
}

}  // namespace omni::protocol
