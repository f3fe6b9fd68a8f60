#include "tests/hil/time/clock/timers.h"

#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>

namespace omni::hil {
namespace {

constexpr timespec kLookAtMaster{.tv_sec = 1, .tv_nsec = 0};
constexpr int kMasterGone = 70;  // EX_SOFTWARE

void Raise(int event_fd, std::uint64_t times) { syscall(SYS_write, event_fd, &times, sizeof times); }

}  // namespace

Timers::Timers(ClockPage& page, ClockProcess& slot) : page_(page), slot_(slot) {}

void Timers::Start(Timer& timer, std::int64_t due_ns, std::int64_t period_ns) {
  const std::lock_guard lock(mutex_);
  timer.due_ns = due_ns;
  timer.period_ns = period_ns;
  if (std::find(timers_.begin(), timers_.end(), &timer) == timers_.end()) timers_.push_back(&timer);
  FireDue();
}

void Timers::Remove(Timer& timer) {
  const std::lock_guard lock(mutex_);
  timers_.erase(std::remove(timers_.begin(), timers_.end(), &timer), timers_.end());
  FireDue();
}

Timer Timers::Look(const Timer& timer) const {
  const std::lock_guard lock(mutex_);
  return timer;
}

// The master sets the time, then checks what is due; here it is the reverse, so that one of the two sees the other.
void Timers::FireDue() {
  for (;;) {
    const std::int64_t now_ns = page_.now_ns.load();
    std::int64_t first_ns = kNever_ns;
    for (Timer* const timer : timers_) {
      if (timer->due_ns <= now_ns) {
        const std::int64_t more = timer->period_ns > 0 ? (now_ns - timer->due_ns) / timer->period_ns : 0;
        Raise(timer->event_fd, static_cast<std::uint64_t>(more + 1));
        if (timer->condition != nullptr) pthread_cond_broadcast(timer->condition);
        timer->due_ns = timer->period_ns > 0 ? timer->due_ns + (more + 1) * timer->period_ns : kNever_ns;
      }
      first_ns = std::min(first_ns, timer->due_ns);
    }
    slot_.due_ns.store(first_ns);
    if (first_ns > page_.now_ns.load()) return;
  }
}

void Timers::Serve() {
  for (;;) {
    const std::uint32_t seen = slot_.wake.load();
    {
      const std::lock_guard lock(mutex_);
      FireDue();
    }
    FutexWait(slot_.wake, seen, kLookAtMaster);
    if (kill(page_.master_pid.load(), 0) != 0 && errno == ESRCH) {
      std::fprintf(stderr, "the virtual clock's master has ended: process %d exits too\n", getpid());
      _exit(kMasterGone);
    }
  }
}

}  // namespace omni::hil
