// A mutex for what the control thread shares with ordinary threads: while it waits, the holder has its priority
// [pthread_mutexattr_setprotocol(3)]. Otherwise busy programs could keep the holder, and with it the control thread,
// from running.
#pragma once

#include <pthread.h>

#include <mutex>

namespace omni::base {

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
