// The threads of this process for which real-time scheduling is meant: named, so that a person or rtkit can promote
// them and no other, and taken out of real time when they use more of it than the system allows.
#pragma once

#include <pthread.h>
#include <sys/types.h>

#include <mutex>
#include <string>
#include <vector>

namespace omni::base {

inline constexpr std::size_t kRealtimeThreadsMax = 8;

// While it lives, the calling thread has this name (a literal of at most 15 characters) and is in the list.
class RealtimeThread {
 public:
  explicit RealtimeThread(const char* name) noexcept;
  ~RealtimeThread();
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;

 private:
  std::size_t slot_;  // kRealtimeThreadsMax: the list is full
};

struct ListedThread {
  std::string name;
  pid_t id = 0;
  bool realtime = false;  // now: SCHED_FIFO or SCHED_RR
};
std::vector<ListedThread> RealtimeThreads();

// From now on SIGXCPU (RLIMIT_RTTIME: too long without a pause in real time [getrlimit(2)]) puts the listed threads
// back to SCHED_OTHER instead of ending the process.
void LeaveRealtimeAtLimit() noexcept;

// A mutex for what the control thread shares with ordinary threads: while it waits, the holder has its priority
// [pthread_mutexattr_setprotocol(3)]. Otherwise busy programs could keep the holder, and with it the control thread,
// from running.

// Also for std::condition_variable, by std::unique_lock<std::mutex>.
class PriorityMutex : public std::mutex {
 public:
  PriorityMutex() noexcept {
    pthread_mutexattr_t attributes;
    pthread_mutexattr_init(&attributes);
    if (pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT) == 0) {
      pthread_mutex_init(native_handle(), &attributes);
    }
    pthread_mutexattr_destroy(&attributes);
  }
};

}  // namespace omni::base
