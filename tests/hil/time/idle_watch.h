// Waits until a set of processes is idle: there is an instant at which every thread of them sleeps.
//
// From /proc: a thread sleeps when its state says so (proc(5), stat), and has not run since when its times and its
// count of time slices are the same (Documentation/scheduler/sched-stats.rst). Four passes over all threads: counts,
// states, states, counts. A thread that sleeps in both passes and has not run in between has slept from the first to
// the second, and between those passes there is an instant that all have in common. No timing assumptions are made.
//
// A thread that is stopped or has ended sleeps. One that waits for a disk does not.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::hil {

class IdleWatch {
 public:
  // An error: this kernel does not provide the data.
  static base::Status Possible();

  IdleWatch();
  ~IdleWatch();

  // These processes, and this one except for the calling thread; at most `patience_us` of real time. False: a thread
  // was still busy.
  bool Wait(const std::vector<pid_t>& processes, std::int64_t patience_us);

  // A thread that was busy when Wait gave up: "process (thread)".
  const std::string& busy() const { return busy_; }

 private:
  class Thread;
  struct Process;

  void Follow(const std::vector<pid_t>& processes);
  void List(Process& process);
  bool AllSleep();
  bool IsIdle();

  pid_t own_thread_;
  std::vector<Process> processes_;
  double usual_us_ = 0;  // recent duration of a wait: no use in checking much earlier
  std::string busy_;
};

}  // namespace omni::hil
