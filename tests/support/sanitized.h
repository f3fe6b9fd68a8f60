// Whether this program is instrumented: it has a heap and system calls of its own then, and must be a program's first
// library.
#pragma once

namespace omni::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace omni::test
