// Memory for what a tick reads at random: large blocks start on a huge page and ask for huge pages, because at 1e6
// triangles a walk of the page table costs more than the data. The kernel may decline; then it is ordinary memory.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <utility>

namespace omni::base {

template <class T>
struct BigBlockAllocator {
  using value_type = T;
  static constexpr std::size_t kHugePage = std::size_t{1} << 21;
  static constexpr std::size_t kCacheLine = 64;

  BigBlockAllocator() = default;
  template <class U>
  BigBlockAllocator(const BigBlockAllocator<U>& /*other*/) noexcept {}  // NOLINT(google-explicit-constructor)

  static std::align_val_t Alignment(std::size_t bytes) noexcept {
    return std::align_val_t{bytes >= kHugePage ? kHugePage : kCacheLine};
  }
  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* const memory = ::operator new(bytes, Alignment(bytes));
    if (bytes >= kHugePage) (void)madvise(memory, bytes, MADV_HUGEPAGE);
    return static_cast<T*>(memory);
  }
  // Elements without a value given are not set: a large block takes memory as it is written.
  template <class U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... From>
  void construct(U* place, From&&... from) {
    ::new (static_cast<void*>(place)) U(std::forward<From>(from)...);
  }
  void deallocate(T* memory, std::size_t count) noexcept { ::operator delete(memory, Alignment(count * sizeof(T))); }

  friend bool operator==(const BigBlockAllocator& /*a*/, const BigBlockAllocator& /*b*/) noexcept { return true; }
};

}  // namespace omni::base
