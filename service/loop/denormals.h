// Flush-to-zero and denormals-are-zero for the calling thread: a decaying filter must not cost 100 times more at rest.
// Set wherever Tick runs, so that replay and tests give the same bits as the daemon.
#pragma once

#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace omni::loop {

inline void FlushDenormals() noexcept {
#if defined(__SSE2__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
}

}  // namespace omni::loop
