#include "service/base/threads/realtime_threads.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <fstream>

namespace omni::base {
namespace {

static_assert(std::atomic<pid_t>::is_always_lock_free);  // a signal handler reads it
std::array<std::atomic<pid_t>, kRealtimeThreadsMax> threads;

// Of this thread too, which the kernel has interrupted. Only system calls.
void OnLimit(int) {
  const int kept = errno;
  const sched_param none{};
  for (const std::atomic<pid_t>& thread : threads) {
    if (const pid_t id = thread.load(); id != 0) ::syscall(SYS_sched_setscheduler, id, SCHED_OTHER, &none);
  }
  errno = kept;
}

}  // namespace

RealtimeThread::RealtimeThread(const char* name) noexcept : slot_(0) {
  pthread_setname_np(pthread_self(), name);
  const auto id = static_cast<pid_t>(::syscall(SYS_gettid));
  for (; slot_ < threads.size(); ++slot_) {
    pid_t none = 0;
    if (threads[slot_].compare_exchange_strong(none, id)) return;
  }
}

RealtimeThread::~RealtimeThread() {
  if (slot_ < threads.size()) threads[slot_].store(0);
}

std::vector<ListedThread> RealtimeThreads() {
  std::vector<ListedThread> listed;
  for (const std::atomic<pid_t>& thread : threads) {
    const pid_t id = thread.load();
    if (id == 0) continue;
    ListedThread one{.id = id};
    std::ifstream file("/proc/self/task/" + std::to_string(id) + "/comm");
    std::getline(file, one.name);
    const auto policy = ::syscall(SYS_sched_getscheduler, id) & ~SCHED_RESET_ON_FORK;
    one.realtime = policy == SCHED_FIFO || policy == SCHED_RR;
    listed.push_back(one);
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
