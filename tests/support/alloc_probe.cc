#include "tests/support/alloc_probe.h"

#include <cstddef>
#include <cstdlib>

namespace {

thread_local std::uint64_t heap_calls = 0;

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

void* malloc(std::size_t bytes) {
  ++heap_calls;
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
  ++heap_calls;
  return __libc_calloc(count, bytes);
}
void* realloc(void* block, std::size_t bytes) {
  ++heap_calls;
  return __libc_realloc(block, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) {
  ++heap_calls;
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  ++heap_calls;
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
  ++heap_calls;
  *block = __libc_memalign(alignment, bytes);
  return *block != nullptr ? 0 : 12;  // ENOMEM
}
void free(void* block) {
  ++heap_calls;
  __libc_free(block);
}
}
// NOLINTEND(bugprone-reserved-identifier)

#endif

namespace omni::loop {

AllocProbe::AllocProbe() noexcept : begin_(heap_calls) {}
std::uint64_t AllocProbe::count() const noexcept { return heap_calls - begin_; }

}  // namespace omni::loop
