#include "firmware/board/teensy40/boot/retained.h"

#include "firmware/board/teensy40/boot/memory_map.h"

namespace omni::board {
namespace {

static_assert(sizeof(Retained) <= kRetainedSize, "its place at the end of the on-chip RAM");
// Bytes, not a Retained: no constructor may overwrite the kept data.
__attribute__((section(".retained"), used)) alignas(Retained) unsigned char g_retained[sizeof(Retained)];

}  // namespace

Retained& retained() noexcept { return *reinterpret_cast<Retained*>(g_retained); }

firmware::ResetCause PopResetCause() noexcept {
  const bool crashed = retained().crashed == kCrashed;
  retained().crashed = 0;
  ++retained().resets;
  return PopResetCause(crashed);
}

}  // namespace omni::board
