// The timers of one process under a virtual clock. Each has an eventfd that becomes readable when it is due, so that it
// can be waited for together with other descriptors.
#pragma once

#include <pthread.h>

#include <cstdint>
#include <mutex>
#include <vector>

#include "tests/hil/time/clock/clock_page.h"

namespace omni::hil {

struct Timer {
  std::int64_t due_ns = kNever_ns;
  std::int64_t period_ns = 0;  // 0: once
  int event_fd = -1;
  pthread_cond_t* condition = nullptr;  // signalled too
};

class Timers {
 public:
  // The process takes place `slot` of the page.
  Timers(ClockPage& page, ClockProcess& slot);

  std::int64_t now_ns() const noexcept { return page_.now_ns.load(); }

  // The timer stays where it is until it is removed. Start: again, if it is there already.
  void Start(Timer& timer, std::int64_t due_ns, std::int64_t period_ns);
  void Remove(Timer& timer);
  Timer Look(const Timer& timer) const;

  // Handles timers that are due; never returns. The process ends, with a message, when the clock's master is gone.
  [[noreturn]] void Serve();

 private:
  void FireDue();  // with the mutex held

  ClockPage& page_;
  ClockProcess& slot_;
  mutable std::mutex mutex_;
  std::vector<Timer*> timers_;
};

}  // namespace omni::hil
