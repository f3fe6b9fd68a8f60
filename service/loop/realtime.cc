#include "service/loop/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace omni::loop {

int RequestFifo(int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters);
}

RealtimeStatus RequestRealtime(int priority) {
  RealtimeStatus status;
  const int refused = RequestFifo(priority);
  status.fifo = refused == 0;
  if (!status.fifo) {
    status.reason = std::string("SCHED_FIFO refused (") + std::strerror(refused) +
                    "): install manifests/limits/99-omni-realtime.conf into /etc/security/limits.d and log in again, "
                    "or run the systemd unit (docs/howto/realtime.md)";
  }
  // With a small limit MCL_FUTURE would make later allocations fail: lock all or nothing.
  rlimit memory{};
  getrlimit(RLIMIT_MEMLOCK, &memory);
  errno = EPERM;
  status.memory_locked =
      (geteuid() == 0 || memory.rlim_cur == RLIM_INFINITY) && mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!status.memory_locked) {
    if (!status.reason.empty()) status.reason += "; ";
    status.reason += std::string("mlockall refused (") + std::strerror(errno) +
                     "): raise memlock (ulimit -l, limits.d: 'memlock unlimited')";
  }
  return status;
}

}  // namespace omni::loop
