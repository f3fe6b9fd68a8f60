#include "tests/support/alloc_probe.h"

#include <malloc.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>

namespace {

thread_local std::uint64_t heap_calls = 0;
std::atomic<std::size_t> used_bytes{0}, peak_bytes{0};

}  // namespace

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// [sanitizer/allocator_interface.h]
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));

namespace {

void CountMalloc(const volatile void* /*block*/, std::size_t /*bytes*/) { ++heap_calls; }
void CountFree(const volatile void* /*block*/) { ++heap_calls; }

[[maybe_unused]] const int kInstalled = __sanitizer_install_malloc_and_free_hooks(CountMalloc, CountFree);

}  // namespace

#if defined(__SANITIZE_THREAD__)

// GCC's ThreadSanitizer calls no hook for aligned memory: its own entry points behind the public names.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __interceptor_memalign(std::size_t alignment, std::size_t bytes);
void* __interceptor_aligned_alloc(std::size_t alignment, std::size_t bytes);
int __interceptor_posix_memalign(void** block, std::size_t alignment, std::size_t bytes);

void* memalign(std::size_t alignment, std::size_t bytes) {
  ++heap_calls;
  return __interceptor_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  ++heap_calls;
  return __interceptor_aligned_alloc(alignment, bytes);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
  ++heap_calls;
  return __interceptor_posix_memalign(block, alignment, bytes);
}
}
// NOLINTEND(bugprone-reserved-identifier)

#endif

#else

// glibc's own entry points behind the public names.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* block, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* block);
}
// NOLINTEND(bugprone-reserved-identifier)

namespace {

void Count(void* block) noexcept {
  const std::size_t bytes = malloc_usable_size(block);
  const std::size_t now = used_bytes.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  std::size_t most = peak_bytes.load(std::memory_order_relaxed);
  while (now > most && !peak_bytes.compare_exchange_weak(most, now, std::memory_order_relaxed)) {
  }
}
void Uncount(void* block) noexcept { used_bytes.fetch_sub(malloc_usable_size(block), std::memory_order_relaxed); }
void* Counted(void* block) noexcept {
  ++heap_calls;
  Count(block);
  return block;
}

}  // namespace

extern "C" {
void* malloc(std::size_t bytes) { return Counted(__libc_malloc(bytes)); }
void* calloc(std::size_t count, std::size_t bytes) { return Counted(__libc_calloc(count, bytes)); }
void* realloc(void* block, std::size_t bytes) {
  Uncount(block);
  void* const moved = __libc_realloc(block, bytes);
  if (moved == nullptr && bytes > 0) Count(block);  // it stays where it was
  return Counted(moved);
}
void* memalign(std::size_t alignment, std::size_t bytes) { return Counted(__libc_memalign(alignment, bytes)); }
void* aligned_alloc(std::size_t alignment, std::size_t bytes) { return Counted(__libc_memalign(alignment, bytes)); }
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
  *block = Counted(__libc_memalign(alignment, bytes));
  return *block != nullptr ? 0 : 12;  // ENOMEM
}
void free(void* block) {
  ++heap_calls;
  Uncount(block);
  __libc_free(block);
}
}

#endif

namespace omni::loop {

AllocProbe::AllocProbe() noexcept : begin_(heap_calls) {}
std::uint64_t AllocProbe::count() const noexcept { return heap_calls - begin_; }

HeapPeak::HeapPeak() noexcept : begin_(used_bytes) { peak_bytes = begin_; }
std::size_t HeapPeak::bytes() const noexcept { return peak_bytes - begin_; }

}  // namespace omni::loop
