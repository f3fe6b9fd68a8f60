// AllocProbe: counts heap calls (malloc, calloc, realloc, memalign, free, new, delete) of this thread while it lives.
// It hooks malloc, not only operator new, because Eigen and C libraries bypass the latter. Under ASan and TSan it uses
// the sanitizer's allocator hooks, which see allocations and frees alike.
#pragma once

#include <cstdint>

namespace omni::loop {

class AllocProbe {
 public:
  AllocProbe() noexcept;
  AllocProbe(const AllocProbe&) = delete;
  AllocProbe& operator=(const AllocProbe&) = delete;

  // Heap calls of this thread since construction.
  std::uint64_t count() const noexcept;

 private:
  std::uint64_t begin_;
};

}  // namespace omni::loop
