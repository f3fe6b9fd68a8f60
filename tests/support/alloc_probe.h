// AllocProbe: counts heap calls (malloc, calloc, realloc, memalign, free, new, delete) of this thread while it lives.
// It hooks malloc, not only operator new, because Eigen and C libraries bypass the latter. Under ASan and TSan it uses
// the sanitizer's allocator hooks, which see allocations and frees alike.
#pragma once

#include <cstddef>
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

// The most bytes of the heap that all threads had in use at once since it was made, beyond those in use then: reserved
// is used, written or not. Zero under sanitizers.
class HeapPeak {
 public:
  HeapPeak() noexcept;
  HeapPeak(const HeapPeak&) = delete;
  HeapPeak& operator=(const HeapPeak&) = delete;

  std::size_t bytes() const noexcept;

 private:
  std::size_t begin_;
};

}  // namespace omni::loop
