// One packet in, one packet out, over a non-blocking Unix seqpacket socket. Never blocks, never raises a signal.
#pragma once

#include <cstddef>

#include "service/base/unique_fd.h"

namespace omni::protocol {

inline constexpr std::size_t kMaxPassedFds = 4;

enum class SendResult {
  kSent,
  kFull,  // the peer does not read: the packet was dropped
  kGone   // no peer any more
};
// `fd_count` <= kMaxPassedFds descriptors travel with the packet; they stay the caller's.
SendResult SendPacket(int socket, const void* bytes, std::size_t size, const int* fds = nullptr,
                      std::size_t fd_count = 0) noexcept;

enum class ReceiveResult {
  kPacket,
  kNothing,  // nothing there now
  kEnd,      // the peer has closed, or the socket has failed
  kTooLong,  // a packet longer than the buffer, or one with more descriptors than room for them
  kNoRoom    // this process has as many descriptors open as it may: those of the packet are lost
};
struct Received {
  ReceiveResult result = ReceiveResult::kNothing;
  std::size_t size = 0;
  std::size_t fd_count = 0;
};
// Descriptors that came along land in `fds`, close-on-exec; with no room for them they are closed.
Received ReceivePacket(int socket, void* buffer, std::size_t capacity, base::UniqueFd* fds = nullptr,
                       std::size_t fd_capacity = 0) noexcept;

}  // namespace omni::protocol
