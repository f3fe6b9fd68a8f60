// Real-time scheduling of the calling thread, when the system permits it.
#pragma once

#include <string>

namespace omni::loop {

struct RealtimeStatus {
  bool fifo = false;  // SCHED_FIFO granted
  bool memory_locked = false;
  std::string reason;  // what was refused and how to permit it; empty when both are granted
};

// SCHED_FIFO at `priority` (1..99) for this thread; threads that it starts do not inherit it. 0: granted, else errno.
int RequestFifo(int priority) noexcept;

// The same, and mlockall for the process. At set-up only.
RealtimeStatus RequestRealtime(int priority);

}  // namespace omni::loop
