// Bytes in use on the heap, mapped blocks included.
#pragma once

#include <malloc.h>

namespace omni::collision {

inline double HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

}  // namespace omni::collision
