#include "service/base/threads/realtime_threads.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>

namespace omni::base {
namespace {

struct Slot {
  std::atomic<pid_t> id{0};  // 0: free
  std::atomic<const char*> name{""};
};
static_assert(std::atomic<pid_t>::is_always_lock_free);  // a signal handler reads it
std::array<Slot, kRealtimeThreadsMax> threads;

// Of this thread too, which the kernel has interrupted. Only system calls.
void OnLimit(int) {
  const int kept = errno;
  const sched_param none{};
  for (const Slot& thread : threads) {
    if (const pid_t id = thread.id.load(); id != 0) ::syscall(SYS_sched_setscheduler, id, SCHED_OTHER, &none);
  }
  errno = kept;
}

}  // namespace

RealtimeThread::RealtimeThread(const char* name) noexcept : slot_(0) {
  pthread_setname_np(pthread_self(), name);
  const auto id = static_cast<pid_t>(::syscall(SYS_gettid));
  for (; slot_ < threads.size(); ++slot_) {
    pid_t none = 0;
    if (!threads[slot_].id.compare_exchange_strong(none, id)) continue;
    threads[slot_].name.store(name);
    return;
  }
}

RealtimeThread::~RealtimeThread() {
  if (slot_ < threads.size()) threads[slot_].id.store(0);
}

std::vector<ListedThread> RealtimeThreads() {
  std::vector<ListedThread> listed;
  for (const Slot& thread : threads) {
    const pid_t id = thread.id.load();
    if (id == 0) continue;
    const auto policy = ::syscall(SYS_sched_getscheduler, id) & ~SCHED_RESET_ON_FORK;
    const bool realtime = policy == SCHED_FIFO || policy == SCHED_RR;
    listed.push_back({.name = thread.name.load(), .id = id, .realtime = realtime});
  }
  return listed;
}

void LeaveRealtimeAtLimit() noexcept {
  struct sigaction action {};
  action.sa_handler = OnLimit;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGXCPU, &action, nullptr);
}

}  // namespace omni::base
