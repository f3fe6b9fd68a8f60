#include "service/daemon/end_watch.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/base/clock.h"
#include "service/daemon/log_queue.h"

namespace omni::daemon {
namespace {

void Raise(int event) {
  const std::uint64_t one = 1;
  while (write(event, &one, sizeof one) < 0 && errno == EINTR) {
  }
}

}  // namespace

EndWatch::EndWatch() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signals_.Reset(signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
  asked_.Reset(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  stop_.Reset(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!signals_ || !asked_ || !stop_) throw std::system_error(errno, std::generic_category(), "waiting for signals");
  thread_ = std::thread([this] { Run(); });
}

EndWatch::~EndWatch() {
  Raise(stop_.get());
  thread_.join();
}

bool EndWatch::Wait(int most_ms) const {
  pollfd asked{asked_.get(), POLLIN, 0};
  return poll(&asked, 1, most_ms) > 0;
}

void EndWatch::SetZero(std::function<void()> zero) {
  const std::lock_guard lock(zero_mutex_);
  zero_ = std::move(zero);
}

void EndWatch::Run() {
  std::int64_t deadline_ns = 0;  // 0: not requested
  for (;;) {
    std::array<pollfd, 2> waits = {{{signals_.get(), POLLIN, 0}, {stop_.get(), POLLIN, 0}}};
    const std::int64_t left_ns = std::max<std::int64_t>(0, deadline_ns - base::MonotonicNow_ns());
    poll(waits.data(), waits.size(), deadline_ns == 0 ? -1 : static_cast<int>(left_ns / 1'000'000 + 1));
    if (waits[1].revents != 0) return;
    signalfd_siginfo signal;
    const bool signalled = read(signals_.get(), &signal, sizeof signal) == sizeof signal;
    if (signalled && deadline_ns != 0 && !recording_.load()) EndAtOnce("on a second signal");
    if (signalled && deadline_ns == 0) {
      deadline_ns = base::MonotonicNow_ns() + kPatience_ns;
      Raise(asked_.get());
    }
    if (deadline_ns != 0 && base::MonotonicNow_ns() >= deadline_ns) EndAtOnce("before everything has shut down");
  }
}

void EndWatch::EndAtOnce(const char* why) {
  {
    const std::lock_guard lock(zero_mutex_);
    if (zero_) zero_();
  }
  const bool recording = recording_.load();
  spdlog::warn("the service exits now, {}{}", why, recording ? "; a recording is incomplete" : "");
  LogQueue::Flush(kLogWait_ms);
  _exit(recording ? 1 : 0);
}

}  // namespace omni::daemon
