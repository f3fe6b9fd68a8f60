// One thread notifies another, which waits with a deadline. An eventfd: neither side allocates, takes a lock or blocks
// the other.
#pragma once

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

#include "service/base/clock.h"
#include "service/base/unique_fd.h"

namespace omni::device {

class ReadyEvent {
 public:
  ReadyEvent() noexcept : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

  int fd() const noexcept { return fd_.get(); }
  bool valid() const noexcept { return static_cast<bool>(fd_); }

  // Any thread.
  void Signal() const noexcept {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = write(fd_.get(), &one, sizeof one);  // full: already signalled
  }
  // The waiting thread. Check for news after Clear, not before: anything in between is signalled again.
  void Clear() const noexcept {
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t got = read(fd_.get(), &count, sizeof count);
  }
  // Until signalled. False: `deadline_ns` (CLOCK_MONOTONIC) has passed. An interrupted wait counts as a signal.
  bool Wait(std::int64_t deadline_ns) const noexcept {
    const std::int64_t left_ns = deadline_ns - base::MonotonicNow_ns();
    if (left_ns <= 0) return false;
    const timespec timeout{left_ns / 1'000'000'000, left_ns % 1'000'000'000};
    pollfd poll{fd_.get(), POLLIN, 0};
    if (ppoll(&poll, 1, &timeout, nullptr) == 0) return false;
    Clear();
    return true;
  }

 private:
  base::UniqueFd fd_;
};

}  // namespace omni::device
