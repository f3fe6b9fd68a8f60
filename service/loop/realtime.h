// Scheduling of the calling thread in real time, when the system permits it, and its handling of denormals.
#pragma once

#include <string>

#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

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

// Flush-to-zero and denormals-are-zero for the calling thread: a decaying filter must not cost 100 times more at rest.
// Set wherever Tick runs, so that replay and tests give the same bits as the daemon.
inline void FlushDenormals() noexcept {
#if defined(__SSE2__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
}

}  // namespace omni::loop
