// Memory that is given back when it is no longer needed, not when a scope or the process ends.
#pragma once

#include <malloc.h>

namespace omni::base {

// Empties a vector or a string and frees its block. `values = {}` assigns an empty list, which keeps the block.
template <class Container>
void FreeMemory(Container& values) {
  Container().swap(values);
}

// From now on blocks of 1 MiB and more go back to the system when they are freed. glibc would raise that bound to the
// largest block freed so far, at most 32 MiB, and keep what is below it   [mallopt(3), M_MMAP_THRESHOLD].
inline void ReturnFreedBlocks() {
#ifdef M_MMAP_THRESHOLD
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

}  // namespace omni::base
